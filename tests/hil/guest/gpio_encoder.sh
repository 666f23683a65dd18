# An encoder on lines of a simulated chip: the driver's count and angle follow every edge, both ways.
set -eu
. tests/hil/devices.sh
load_gpio_sim
gpio_stage "$chip" "$lines"
unload_gpio_sim
