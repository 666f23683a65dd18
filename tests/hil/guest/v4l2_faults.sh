# vivid's faults under dexeld: buffers that the camera drops are counted as lost, spoiled ones as damaged, and none of
# them reaches the mesh; after a fatal error, and after a disconnect, the stream goes on by itself.
# limit: 120
set -eu
. tests/daemon.sh
. tests/hil/devices.sh

load_vivid
video_set "$video" 'Test Pattern' 4 'OSD Text Mode' 2
video_grab "$video" Y16 320x180 2 "$run/pixels"
depth_stream v4l2 320x180 'format: Y16' 'size: 320x180' "path: $video" 'fps: 30'
start_dexeld -c "$run/dexeld.yaml"
await 20 device_is state streaming
depth_expect 1 "$run/pixels"

video_set "$video" 'Percentage of Dropped Buffers' 50
await 20 device_above lost 3
video_set "$video" 'Percentage of Dropped Buffers' 0
echo "lost $(device lost)"

device_is damaged 0 || wrong "damaged: $(status)"
video_set "$video" 'Inject V4L2_BUF_FLAG_ERROR' 1
await 20 device_above damaged 0

video_set "$video" 'Inject Fatal Streaming Error' 1
# by the driver itself, or as a fault
went_on() { device_tells trouble 'started anew' || device_above faults 0; }
await 60 went_on
await 60 device_is state streaming
depth_expect 1 "$run/pixels"
status

# the node is back when the last one has closed it
video_set "$video" 'Disconnect' 1
await 60 device_is unplugged 1
await 60 device_is state streaming
depth_expect 1 "$run/pixels"
status
stop_dexeld
rmmod vivid
