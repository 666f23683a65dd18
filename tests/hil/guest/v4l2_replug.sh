# A USB camera comes after dexeld, goes in the middle of a frame, comes again under another node, and once more. A
# subscriber who is there all the time gets nothing but whole frames.
# limit: 120
set -eu
. tests/daemon.sh
. tests/hil/devices.sh

modprobe xhci-pci
modprobe uvcvideo
depth_stream v4l2 640x480 'format: auto' 'size: 640x480' 'serial: HIL0001'
start_dexeld -c "$run/dexeld.yaml"
await 10 device_is state absent
depth_expect 12 &
patient=$!

load_camera
await 30 device_is state streaming
depth_expect 3
exec 5<"$video" # its number stays taken
camera unplug-in
await 30 device_is state gone

was=$video
load_camera
[ "$video" != "$was" ] || wrong "still $was"
exec 5<&-
await 60 device_is state streaming
depth_expect 3

camera unplug
await 30 device_is state gone
camera plug
await 60 device_is state streaming
wait $patient
device_is unplugged 2 || wrong "$(status)"
status
stop_dexeld
camera unplug
