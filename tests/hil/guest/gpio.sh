# A simulated GPIO chip, its label and a line's name, and edges as libgpiod will see them.
set -eu
. tests/hil/devices.sh
load_gpio_sim
gpio_edges "$chip" 2 "$lines/sim_gpio2/pull" 100
unload_gpio_sim
