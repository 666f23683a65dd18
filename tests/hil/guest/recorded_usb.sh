# The USB depth camera recorded by dexeld: the recording replays to the meshes of the live run.
# limit: 400
set -eu
. tests/daemon.sh
. tests/hil/devices.sh

load_camera
camera 'fps 3'
depth_stream v4l2 640x480 'serial: HIL0001'
recorded
start_dexeld -c "$run/dexeld.yaml"
replays_as_live 4
camera 'fps 30'
camera unplug
