# A minute of the USB camera at 30 frames a second: each frame that it sent has come, or dexeld knows that it has not.
# With hil_strict none may be lost at all: a busy host cannot keep that.
# limit: 240
set -eu
. tests/daemon.sh
. tests/hil/devices.sh

load_camera
depth_stream auto 640x480 'serial: HIL0001'
start_dexeld -c "$run/dexeld.yaml"
await 200 camera_sent 1800
camera unplug
await 30 device_is state gone
camera count
status
stop_dexeld

# sent N missed N
# shellcheck disable=SC2086 # words
set -- $answer
sent=$2 missed=$4
counted=$(($(frames_come) + $(device_lost)))
