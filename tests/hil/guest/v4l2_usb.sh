# The USB depth camera through dexeld's V4L2 driver, chosen by its serial number: every value of every mesh.
# limit: 60
set -eu
. tests/daemon.sh
. tests/hil/devices.sh

load_camera
depth_stream v4l2 640x480 'format: auto' 'size: 640x480' 'serial: HIL0001'
start_dexeld -c "$run/dexeld.yaml"
depth_expect 10
status
stop_dexeld
camera unplug
