# A Kinect's camera by isochronous transfers through xhci and usbfs: every value of its meshes; packets that are lost
# make holes, which is told; unplugged in the middle of a frame, and plugged again.
# limit: 240
set -eu
. tests/daemon.sh
. tests/hil/devices.sh

modprobe xhci-pci
depth_stream kinect 640x480 'serial: A00HIL0000000001' 'fy: 640'
start_dexeld -c "$run/dexeld.yaml"
await 10 device_is state absent
kinect plug
depth_expect 3 expected/kinect.pixels

kinect 'lose 40000'
await 60 device_tells trouble 'packets are lost'
kinect 'lose 0'
await 60 device_is trouble ''
depth_expect 1 expected/kinect.pixels

kinect unplug-in
await 30 device_is state gone
kinect plug
depth_expect 2 expected/kinect.pixels
device_is unplugged 1 || wrong "$(status)"
status
stop_dexeld
kinect unplug
