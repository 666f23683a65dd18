# Within the sandbox, every kind of device is opened and streams: a camera (vivid), a scanner by libusb (which takes it from the kernel's
# driver) and then by its serial port (the kernel's CDC-ACM on dummy_hcd), the encoder of its stage on GPIO lines (gpio-sim). What
# subscribers get is right, value by value and, of the scanner by libusb, wall by wall.
# limit: 300
set -eu
. tests/hil/devices.sh
. tests/hil/installed.sh

load_vivid
video_set "$video" 'Test Pattern' 4 'OSD Text Mode' 2
video_grab "$video" Y16 320x180 2 /run/hil/pixels
load_gpio_sim
load_scip_gadget
run=/run/hil/devices
mkdir -p $run
gpio_turn "$lines" 4 400 "$run/track" &
turning=$!
await 60 test -s "$run/track"
scip_scanner --track "$run/track"
plug_scip
await 60 test -c /dev/ttyACM0
ln -s /run/dexeld/*.sock "$run"

# streams HOKUYO_KEY
streams() {
  cat >$config <<YAML
streams:
  - name: camera
    v4l2: {format: Y16, size: 320x180, fx: 320, path: $video}
  - name: turret
    hokuyo:
      $1
      stage:
        encoder: {a: "$chip:0", b: "$chip:1", z: encoder-index, counts: 400}
        columns: 30
        sweep: half
        exact: yes
YAML
}
# what the turret measures counts from the encoder's first index on
turns() { device_is state streaming && device_is trouble ''; }
open_devices() { find "/proc/$(shown MainPID)/fd" -printf '%l\n' | grep '^/dev/' | grep -v '^/dev/null' | sort -u; }
is_open() { open_devices | grep -q "^$1"; }

streams 'port: ""'
systemctl restart dexeld.service
width=320 height=180 depth_expect 2 /run/hil/pixels
await 60 is_open /dev/bus/usb/
await 60 turns
scip_expect 1 turret
open_devices
is_open "$video" && is_open "/dev/$chip" || wrong 'a device is not open'
[ ! -e /dev/ttyACM0 ] || wrong 'the kernel still has the scanner'

streams 'tty: /dev/ttyACM0'
systemctl restart dexeld.service
await 60 is_open /dev/ttyACM0
await 60 turns
was_parts=$(counted parts)
has_more() { [ "$(counted parts)" -gt $((was_parts + 20)) ]; }
await 60 has_more
open_devices
status
