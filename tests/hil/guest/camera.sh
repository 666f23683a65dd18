# A USB depth camera, a program on the other side of the guest, through the kernel's own xhci and uvcvideo: every
# pixel of every frame; two frames that the camera spoils are left out; unplugged in the middle of one, and
# plugged again.
# limit: 60
set -eu
. tests/hil/devices.sh

load_camera
video_grab "$video" Z16 640x480 60 | tee /tmp/grabbed
camera count
grep -q 'by number 0, by picture 0, damaged 0' /tmp/grabbed || wrong "frames are lost: $answer"

# the kernel counts a spoiled frame, but does not hand it over
camera unplug
await 5 test ! -e "$video"
load_camera
video_grab "$video" Z16 640x480 60 >/tmp/grabbed &
grab=$!
await 10 camera_sent 5
camera cut
await 10 camera_sent 15
camera bad
wait $grab
cat /tmp/grabbed
grep -q 'by number 2, by picture 2, damaged 0' /tmp/grabbed

video_grab "$video" Z16 640x480 1000 2>/tmp/grabbed &
grab=$!
await 10 camera_sent 70
camera unplug-in
if wait $grab; then wrong 'it was not unplugged'; fi
grep 'No such device' /tmp/grabbed
await 5 test ! -e "$video"
load_camera
video_grab "$video" Z16 640x480 10
camera unplug
