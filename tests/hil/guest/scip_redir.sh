# A scanner on USB that is a program outside (redir_scip.c): CDC-ACM by libusb through xhci and usbfs, taken from the kernel's
# driver, found by the serial number that it tells itself. Every vertex lies where it must; damaged scans are left out, and when
# there are no others that is told; pulled out at random bytes, and plugged into either port (replug.sh).
# limit: 600
set -eu
. tests/daemon.sh
. tests/hil/devices.sh
. tests/hil/replug.sh
[ -n "$(word hil_cycles)" ] || cycles=3

modprobe xhci-pci
modprobe cdc-acm
scanner plug
await 10 test -c /dev/ttyACM0
scip_stream 'serial: H0614967'
sed -i 's/rpm: 6/rpm: 30/' "$run/dexeld.yaml"
small_pages
start_dexeld -c "$run/dexeld.yaml"
scip_revolved 2
[ ! -e /dev/ttyACM0 ] || wrong 'the kernel still has the scanner'
device_is serial H0614967 || wrong "$(status)"

scanner 'bad-sum 3'
await 60 device_above damaged 2
scip_revolved 1
scanner 'bad-sum 1'
await 60 device_tells reason 'nothing but damaged data'
scanner 'bad-sum 0'
await 60 device_is state streaming

# while it is out there is no frame but the last
whole() { [ "$1" = 1 ] || scip_revolved "$1"; }
replug scanner 40000 whole
stop_dexeld
await 10 test -c /dev/ttyACM0
scanner unplug
rmmod cdc-acm
