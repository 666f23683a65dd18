# An interlock on a simulated chip: the laser's line follows it, and is off at the end.
set -eu
. tests/hil/devices.sh
load_gpio_sim
gpio_rig "$chip" "$lines"
unload_gpio_sim
