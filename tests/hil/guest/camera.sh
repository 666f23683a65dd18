# A USB depth camera, a program on the other side of the guest, through the kernel's own xhci and uvcvideo: every
# pixel of every frame, and no frame lost that is not accounted for; two frames that the camera spoils are left
# out; unplugged in the middle of one, and plugged again.
# limit: 60
set -eu
. tests/hil/devices.sh

# grabbed LEAST: what video_grab has printed: at least so many numbers left out by the kernel; pictures left out
# besides are those that the camera did not send, for nobody fetched them
grabbed() {
  cat /tmp/grabbed
  least=$1
  # frames N lost N by-picture N damaged N
  # shellcheck disable=SC2046 # words
  set -- $(cat /tmp/grabbed)
  lost=$4 pictures=$6 damaged=$8
  camera count
  echo "$answer"
  missed=${answer##* }
  [ "$lost" -ge "$least" ] && [ "$damaged" = 0 ] || wrong "expected at least $least lost, none damaged"
  [ "$pictures" -ge "$lost" ] && [ $((pictures - lost)) -le "$missed" ] || wrong "the camera missed $missed alone"
}

load_camera
video_grab "$video" Z16 640x480 60 >/tmp/grabbed
grabbed 0
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
grabbed 2

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
await 5 test ! -e "$video"
