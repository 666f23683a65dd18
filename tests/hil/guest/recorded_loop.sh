# A camera of v4l2loopback recorded by dexeld: the recording replays to the meshes of the live run.
# limit: 120
set -eu
. tests/daemon.sh
. tests/hil/devices.sh

modprobe v4l2loopback video_nr=10 card_label=loop
udevadm settle
loop_writer /dev/video10 Z16 320x240 3 100000 &
writer=$!
await 5 grep -q '320x240' /sys/class/video4linux/video10/format
depth_stream v4l2 320x240 'format: Z16' 'size: 320x240' 'path: /dev/video10'
recorded
start_dexeld -c "$run/dexeld.yaml"
replays_as_live 6
kill $writer
wait $writer || true
rmmod v4l2loopback
