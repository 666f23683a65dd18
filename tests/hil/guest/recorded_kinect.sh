# The Kinect recorded by dexeld: the recording replays to the meshes of the live run. It shows the same picture all the
# time, so packets are lost: no two frames are alike.
# limit: 400
set -eu
. tests/daemon.sh
. tests/hil/devices.sh

modprobe xhci-pci
depth_stream kinect 640x480 'serial: A00HIL0000000001' 'fy: 640'
recorded
kinect 'fps 3'
kinect plug
kinect 'lose 20000'
start_dexeld -c "$run/dexeld.yaml"
replays_as_live 4
kinect 'fps 10'
kinect unplug
