# The same scanner on USB, by the kernel's CDC-ACM on both sides: by its tty, then by libusb, which takes it from the
# kernel's driver; unplugged while it streams, and plugged again.
# limit: 240
set -eu
. tests/daemon.sh
. tests/hil/devices.sh

load_scip_gadget
scip_scanner
plug_scip
await 10 test -c /dev/ttyACM0
scip_stream "tty: /dev/ttyACM0"
start_dexeld -c "$run/dexeld.yaml"
scip_expect 1
stop_dexeld

scip_stream
start_dexeld -c "$run/dexeld.yaml"
scip_expect 1
[ ! -e /dev/ttyACM0 ] || wrong 'the kernel still has the scanner'
unplug_scip
await 20 device_is state gone
plug_scip
await 60 device_is state streaming
scip_expect 1
status
stop_dexeld
await 10 test -c /dev/ttyACM0
unplug_scip
unload_scip_gadget
