# The USB camera is pulled out at random bytes, through uvcvideo, and plugged into either port (replug.sh).
# limit: 400
set -eu
. tests/daemon.sh
. tests/hil/devices.sh
. tests/hil/replug.sh

load_camera
depth_stream v4l2 640x480 'format: auto' 'size: 640x480' 'serial: HIL0001'
small_pages
start_dexeld -c "$run/dexeld.yaml"
replug camera $((2 * 640 * 480 * 2)) depth_expect
stop_dexeld
camera unplug
