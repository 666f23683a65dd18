# `dexel devices` lists what is attached, with the keys that choose it; what it prints is a configuration that works.
# limit: 120
set -eu
. tests/daemon.sh
. tests/hil/devices.sh

load_camera
kinect plug
load_scip_gadget
scip_scanner
plug_scip
await 10 test -c /dev/ttyACM0
await 10 sh -c 'dexel devices | grep -q "Xbox NUI"'
dexel devices | tee "$run/listed"
for text in 'HIL0001' 'A00HIL0000000001' 'URG-Series'; do
  grep -q "$text" "$run/listed" || wrong "$text is not listed"
done
kinect unplug
camera unplug
unplug_scip
