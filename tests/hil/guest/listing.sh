# `dexel devices` lists what is attached, with the keys that choose it; and nothing any more when it has gone.
# limit: 90
set -eu
. tests/daemon.sh
. tests/hil/devices.sh

listed() { dexel devices 2>&1 | grep -q "$1"; }

load_camera
kinect plug
await 20 listed 'serial: "A00HIL0000000001"'
dexel devices >"$run/listed"
cat "$run/listed"
grep -A 4 'Simulated depth camera, Z16' "$run/listed" | grep 'serial: "HIL0001"'
grep -A 4 'Kinect for Xbox 360' "$run/listed" | grep "node /dev/bus/usb/"

kinect unplug
camera unplug
await 20 listed 'no device is attached'
