# The whole turret: the scanner on USB, which libusb takes from the kernel's CDC-ACM driver, on a stage whose angle only an encoder on
# GPIO lines tells, through dexeld to a subscriber. Every vertex of two whole turns lies on a wall of the room that
# the scanner stands in, within the bounds of room_check.c, and every wall is there.
# limit: 240
set -eu
. tests/daemon.sh
. tests/hil/devices.sh

load_gpio_sim
gpio_turn "$lines" 3 400 "$run/track" &
turning=$!
load_scip_gadget
await 5 test -s "$run/track"
scip_scanner --track "$run/track"
plug_scip
await 10 test -c /dev/ttyACM0
cat >"$run/dexeld.yaml" <<YAML
socket: $run/mesh.sock
control_socket: $run/control.sock
streams:
  - name: turret
    hokuyo:
      stage:
        encoder: {a: "$chip:0", b: "$chip:1", z: encoder-index, counts: 400}
        columns: 90
        sweep: half
        exact: yes
YAML
start_dexeld -c "$run/dexeld.yaml"
await 60 device_is state streaming
[ ! -e /dev/ttyACM0 ] || wrong 'the kernel still has the scanner'
await 60 device_is trouble ''   # the index
scip_expect 4
status
stop_dexeld
unplug_scip
unload_scip_gadget
kill $turning
wait $turning || true
unload_gpio_sim
