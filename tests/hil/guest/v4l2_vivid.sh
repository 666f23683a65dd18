# A camera of vivid (Y16) that shows squares: what a subscriber of dexeld gets is what a plain program takes from the
# same node, value by value.
# limit: 60
set -eu
. tests/daemon.sh
. tests/hil/devices.sh

load_vivid
video_set "$video" 'Test Pattern' 4 'OSD Text Mode' 2
video_grab "$video" Y16 320x180 2 "$run/pixels"
video_grab "$video" Y16 320x180 2 "$run/again"
cmp "$run/pixels" "$run/again"

depth_stream v4l2 320x180 'format: Y16' 'size: 320x180' "path: $video"
start_dexeld -c "$run/dexeld.yaml"
depth_expect 3 "$run/pixels"
status
stop_dexeld
rmmod vivid
