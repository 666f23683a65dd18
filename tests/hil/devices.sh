# Sourced by tests in the guest: kernel devices, made and waited for.

wrong() { echo "$1"; exit 1; }

# await SECONDS COMMAND...: until COMMAND succeeds; looks again ten times a second
await() {
  tries=$(($1 * 10))
  shift
  until "$@" >/dev/null 2>&1; do
    tries=$((tries - 1))
    [ $tries -gt 0 ] || wrong "waited in vain: $*"
    sleep 0.1
  done
}

# video_of NAME: prints the node of the first V4L2 device whose name begins so
video_of() {
  for d in /sys/class/video4linux/video*; do
    case $(cat "$d/name" 2>/dev/null) in "$1"*) echo "/dev/${d##*/}"; return ;; esac
  done
  return 1
}

# load_vivid: one capture device; its node is $video
load_vivid() {
  modprobe vivid n_devs=1 node_types=0x1
  udevadm settle
  video=$(video_of vivid) || wrong "no node of vivid"
}

# load_gpio_sim: eight lines, the third named encoder-index; the chip is $chip, and `pull LINE up|down` drives it
load_gpio_sim() {
  modprobe gpio-sim
  sim=/sys/kernel/config/gpio-sim/dexel
  mkdir -p $sim/bank/line2
  echo 8 >$sim/bank/num_lines
  echo dexel-sim >$sim/bank/label
  echo encoder-index >$sim/bank/line2/name
  echo 1 >$sim/live
  udevadm settle
  chip=$(cat $sim/bank/chip_name)
  lines=/sys/devices/platform/$(cat $sim/dev_name)/$chip
}
pull() { echo "pull-$2" >"$lines/sim_gpio$1/pull"; }
unload_gpio_sim() {
  echo 0 >$sim/live
  rmdir $sim/bank/line2 $sim/bank $sim
  rmmod gpio-sim
}

# camera ORDER: to redir_uvc on the other side; its answer is $answer
camera() {
  exec 4<>/dev/ttyS2
  echo "$1" >&4
  read -r answer <&4
  exec 4>&-
}

# camera_sent N: the camera has sent so many frames since it was plugged in
camera_sent() {
  camera count
  # shellcheck disable=SC2086 # words
  set -- "$1" $answer
  [ "$3" -ge "$1" ]
}

# load_camera: plugs the USB camera in; its node is $video
load_camera() {
  [ -e /dev/ttyS2 ] && modprobe xhci-pci && modprobe uvcvideo
  camera plug
  await 10 video_of 'Simulated depth'
  udevadm settle
  video=$(video_of 'Simulated depth')
}

# depth_stream FORMAT WxH KEYS...: a configuration, $run/dexeld.yaml, with a stream "camera" of the V4L2 driver; the
# camera's axis meets the middle, its focal length is as many pixels as it is wide. KEYS: "path: /dev/video0"
depth_stream() {
  width=${2%x*} height=${2#*x}
  {
    echo "socket: $run/mesh.sock"
    echo "control_socket: $run/control.sock"
    echo "streams:"
    echo "  - name: camera"
    echo "    v4l2:"
    echo "      format: $1"
    echo "      size: $2"
    echo "      fx: $width"
    shift 2
    for key in "$@"; do echo "      $key"; done
  } >"$run/dexeld.yaml"
}

# depth_expect N [FILE]: a subscriber gets N commits of what the camera shows (depth_check.c)
depth_expect() {
  n=$1
  shift
  depth_check "$run/mesh.sock" camera "$n" "$width" "$width" "$(half $((width - 1)))" "$(half $((height - 1)))" "$@"
}
half() { echo "$(($1 / 2)).$(($1 % 2 * 5))"; }

# status: the service's own words
status() { dexel status --socket "$run/control.sock" --json; }

# device KEY: what the status says of the stream's device: its "state", "lost", "damaged" ...
device() { status | sed -n 's/.*"device":{\([^}]*\)}.*/\1/p' | tr , '\n' | sed -n "s/^\"$1\":\"*\([^\"]*\)\"*$/\1/p"; }
device_is() { [ "$(device "$1")" = "$2" ]; }
# device_above KEY N
device_above() { [ "$(device "$1")" -gt "$2" ]; }
