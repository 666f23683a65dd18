# Sourced by tests in the guest: kernel devices, made and waited for.

wrong() { echo "$1"; exit 1; }

# word NAME: its value on the kernel's command line
word() { sed -n "s/.*\\b$1=\\([^ ]*\\).*/\\1/p" /proc/cmdline; }

# await SECONDS COMMAND...: until COMMAND succeeds; looks again ten times a second
await() {
  until_s=$(($(up_s) + $1))
  shift
  until "$@" >/dev/null 2>&1; do
    [ "$(up_s)" -lt $until_s ] || wrong "waited in vain: $*"
    sleep 0.1
  done
}
up_s() { cut -d. -f1 /proc/uptime; }

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

# camera ORDER, kinect ORDER, scanner ORDER: to redir_uvc, redir_kinect and redir_scip on the other side; the answer is
# $answer
camera() { order /dev/ttyS2 "$1"; }
kinect() { order /dev/ttyS3 "$1"; }
scanner() { order /dev/ttyS4 "$1"; }
order() {
  exec 4<>"$1"
  echo "$2" >&4
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

# depth_stream DRIVER WxH KEYS...: a configuration, $run/dexeld.yaml, with a stream "camera" of a driver of depth cameras; the
# camera's axis meets the middle, its focal length is as many pixels as it is wide. KEYS: "path: /dev/video0"
depth_stream() {
  driver=$1 width=${2%x*} height=${2#*x}
  shift 2
  {
    echo "socket: $run/mesh.sock"
    echo "control_socket: $run/control.sock"
    echo "streams:"
    echo "  - name: camera"
    echo "    $driver:"
    echo "      fx: $width"
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

# recorded: the configuration's stream is recorded as well. Its noise is given: else the first frame that was meshed decides
# it, and a replay meshes the very first
recorded() {
  {
    echo "    commit_ms: 60000"
    echo "    mesh: {sigma: [0.001, 0, 0.001]}"
    echo "    record: {path: $run/recorded.mcap}"
  } >>"$run/dexeld.yaml"
}
# replays_as_live N: N meshes of the stream that is being recorded; when dexeld has been stopped, the recording gives meshes of the
# same frames with the same digests (mesh_digests.c)
replays_as_live() {
  mesh_digests "$run/mesh.sock" live "$1" >"$run/live"
  stop_dexeld
  start_dexeld --replay "$run/recorded.mcap" --rate max --wait 1 --socket "$run/mesh.sock"
  mesh_digests "$run/mesh.sock" lossless >"$run/replayed"
  stop_dexeld
  echo "live:" && cat "$run/live"
  echo "replayed: $(wc -l <"$run/replayed") frames"
  [ "$(cut -d' ' -f2 "$run/live" | sort -u | wc -l)" = "$1" ] || wrong 'frames with the same mesh prove nothing'
  grep -Fxvf "$run/replayed" "$run/live" || return 0
  wrong "the replay differs: $(cat "$run/replayed")"
}

# scip_stream KEYS...: a configuration, $run/dexeld.yaml, with a stream of a SCIP scanner on a stage that turns by 6
# rounds a minute; scip_scanner starts the scanner (scip_sim) at the link $run/scip, and scip_expect N [STREAM]
# waits for N whole frames of the room that it stands in (room_check.c)
scip_stream() {
  {
    echo "socket: $run/mesh.sock"
    echo "control_socket: $run/control.sock"
    echo "streams:"
    echo "  - name: turret"
    echo "    hokuyo:"
    echo "      stage: {rpm: 6, sweep: half, exact: yes}"
    for key in "$@"; do echo "      $key"; done
  } >"$run/dexeld.yaml"
}
scip_scanner() {
  scip_sim --pty "$run/scip" --model urg-04lx --rpm 6 --room=-2,-1.5,-0.8,3,2.5,1.7 "$@" >"$run/scip.log" &
  await 5 test -e "$run/scip"
}
scip_expect() { room_check "$run/mesh.sock" "$1" -2 -1.5 -0.8 3 2.5 1.7 ${2:+"$2"}; }
# scip_revolved N: the same of a scanner that stands still (redir_scip.c)
scip_revolved() { room_check "$run/mesh.sock" "$1" -2 -1.5 -0.8 3 2.5 1.7 still; }

# A scanner with USB: the gadget side of the kernel's own CDC-ACM on dummy_hcd, joined to $run/scip; plug_scip and
# unplug_scip attach it to the bus. Its tty on the host's side is /dev/ttyACM0.
load_scip_gadget() {
  modprobe dummy_hcd
  modprobe usb_f_acm
  modprobe cdc-acm
  gadget=/sys/kernel/config/usb_gadget/scip
  mkdir -p $gadget/strings/0x409 $gadget/configs/c.1 $gadget/functions/acm.0
  echo 0x15d1 >$gadget/idVendor
  echo 0x0000 >$gadget/idProduct
  echo 'Hokuyo Automatic Co, Ltd.' >$gadget/strings/0x409/manufacturer
  echo 'URG-Series USB Driver' >$gadget/strings/0x409/product
  echo full-speed >$gadget/max_speed
  ln -s $gadget/functions/acm.0 $gadget/configs/c.1
  await 5 test -c /dev/ttyGS0
}
plug_scip() {
  stty -F /dev/ttyGS0 raw -echo
  cat /dev/ttyGS0 >"$run/scip" &
  wires=$!
  cat "$run/scip" >/dev/ttyGS0 &
  wires="$wires $!"
  echo dummy_udc.0 >$gadget/UDC
}
unplug_scip() {
  echo >$gadget/UDC
  # shellcheck disable=SC2086 # words
  kill $wires 2>/dev/null || true
}
unload_scip_gadget() {
  rm $gadget/configs/c.1/acm.0
  rmdir $gadget/configs/c.1 $gadget/functions/acm.0 $gadget/strings/0x409 $gadget
  rmmod usb_f_acm cdc-acm dummy_hcd
}
# device_tells KEY TEXT: TEXT is in it
device_tells() { device "$1" | grep -q "$2"; }
# counted KEY: a number of the stream's: "frames" that were meshed, those skipped in the "mailbox"
counted() { status | sed -n "s/.*\"$1\":\([0-9]*\).*/\1/p"; }
