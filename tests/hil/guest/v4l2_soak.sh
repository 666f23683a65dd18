# A minute of the USB camera at 30 frames a second: each frame that it sent has come, none was lost between the camera and the
# mailbox. The camera has a memory of a second, so that a host that holds the emulated processor up does not
# count as a loss; what it misses all the same, nobody was there to fetch: one in ten at the most. 160x120, which even a
# busy host can emulate; hil_size=640x480 on the kernel's command line needs an idle one.
# limit: 400
set -eu
. tests/daemon.sh
. tests/hil/devices.sh

size=$(word hil_size)
size=${size:-160x120}
load_camera
camera 'memory 30'
depth_stream v4l2 $size 'serial: HIL0001' "size: $size"
start_dexeld -c "$run/dexeld.yaml"
await 380 camera_sent 1800
camera unplug
await 30 device_is state gone
camera count
status

# shellcheck disable=SC2086 # words: sent N missed N
set -- $answer
sent=$2 missed=$4
come=$(($(counted frames) + $(counted mailbox)))
lost=$(device lost)
echo "$size: sent $sent, missed by the camera $missed, come $come, lost $lost, damaged $(device damaged)"
# The last ones may have been with the kernel, or on their way to the mesher; and that some before them were lost is
# seen by the next alone.
known=$((come + lost))
[ $known -le "$sent" ] && [ $known -ge $((sent - 20)) ] || wrong "$known of $sent frames are known of"
[ "$(device damaged)" -le 1 ] || wrong 'frames came damaged'
[ "$lost" = 0 ] || wrong 'frames are lost'
[ $((missed * 10)) -le "$sent" ] || wrong 'this machine is too slow'
stop_dexeld
