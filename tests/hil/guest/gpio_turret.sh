# A scanner on a stage whose angle only the encoder tells, with an interlock, through dexeld: every vertex lies on a wall of
# the room; no frame while the interlock is open; the laser's line follows.
# limit: 240
set -eu
. tests/daemon.sh
. tests/hil/devices.sh

load_gpio_sim
gpio_turn "$lines" 3 400 "$run/track" &
turning=$!
await 5 test -s "$run/track"
scip_scanner --track "$run/track"
cat >"$run/dexeld.yaml" <<EOF
socket: $run/mesh.sock
control_socket: $run/control.sock
streams:
  - name: turret
    hokuyo:
      tty: $run/scip
      stage:
        encoder: {a: "$chip:0", b: "$chip:1", z: encoder-index, counts: 400}
        columns: 90
        sweep: half
        exact: yes
    gpio:
      interlock: {line: "$chip:3", rearm_ms: 100}
      laser: {line: "$chip:4"}
EOF
laser() { [ "$(cat "$lines/sim_gpio4/value")" = "$1" ]; }

start_dexeld -c "$run/dexeld.yaml"
await 20 device_is trouble 'interlock open: laser off'
laser 0 || wrong 'the laser is on at the start'
pull 3 up
await 60 device_is state streaming
laser 1 || wrong 'the laser is off'
await 60 device_is trouble ''   # the index
scip_expect 2
status
pull 3 down
await 10 laser 0
await 20 device_is state stalled
await 10 device_is reason 'interlock open: laser off'
pull 3 up
await 10 laser 1
await 60 device_is state streaming
[ "$(device opens)" = 1 ] || wrong 'the interlock has cost an opening'
stop_dexeld
laser 0 || wrong 'the laser is on after the end'
kill $turning
wait $turning || true
unload_gpio_sim
