# A depth camera of v4l2loopback (Z16), whose pixels a program makes: what a subscriber of dexeld gets is what was
# made, value by value.
# limit: 60
set -eu
. tests/daemon.sh
. tests/hil/devices.sh

modprobe v4l2loopback video_nr=10 card_label=loop
udevadm settle
loop_writer /dev/video10 Z16 320x240 10 100000 &
writer=$!
await 5 grep -q '320x240' /sys/class/video4linux/video10/format

depth_stream v4l2 320x240 'format: Z16' 'size: 320x240' 'path: /dev/video10'
start_dexeld -c "$run/dexeld.yaml"
depth_expect 20
status
stop_dexeld
kill $writer
wait $writer || true
rmmod v4l2loopback
