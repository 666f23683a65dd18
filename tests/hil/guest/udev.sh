# udev tells that a device has come and gone, with the properties that choose one.
set -eu
. tests/hil/devices.sh

udevadm monitor --udev --property --subsystem-match=video4linux >/tmp/monitor &
monitor=$!
await 5 grep -q 'UDEV - ' /tmp/monitor
load_vivid
await 5 grep -q "^DEVNAME=$video" /tmp/monitor
rmmod vivid
await 5 grep -q '^ACTION=remove' /tmp/monitor
kill $monitor
grep -q '^ACTION=add' /tmp/monitor
