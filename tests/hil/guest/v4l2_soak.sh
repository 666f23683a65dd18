# A minute of the USB camera at 30 frames a second: each frame that it sent has come, or is known to be lost. With
# hil_strict on the kernel's command line none may be lost at all: a busy host cannot keep that.
# limit: 400
set -eu
. tests/daemon.sh
. tests/hil/devices.sh

load_camera
depth_stream v4l2 640x480 'serial: HIL0001'
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
echo "sent $sent, missed by the camera $missed, come $come, lost $lost, damaged $(device damaged)"
# The last ones may have been with the kernel, or on their way to the mesher; and that some before them were lost is
# seen by the next alone.
known=$((come + lost))
[ $known -le "$sent" ] && [ $known -ge $((sent - 60)) ] || wrong "$known of $sent frames are known of"
[ "$(device damaged)" -le 1 ] || wrong 'frames came damaged'
if grep -qw hil_strict /proc/cmdline; then
  [ "$lost" = 0 ] && [ "$missed" = 0 ] || wrong 'frames are lost'
fi
stop_dexeld
