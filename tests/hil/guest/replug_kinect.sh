# The Kinect is pulled out at random bytes of its isochronous packets, through usbfs, and plugged into either port
# (replug.sh).
# limit: 400
set -eu
. tests/daemon.sh
. tests/hil/devices.sh
. tests/hil/replug.sh

modprobe xhci-pci
depth_stream kinect 640x480 'serial: A00HIL0000000001' 'fy: 640'
small_pages
start_dexeld -c "$run/dexeld.yaml"
kinect plug
whole() { depth_expect "$1" expected/kinect.pixels; }
replug kinect $((2 * 640 * 480 * 11 / 8)) whole
stop_dexeld
kinect unplug
