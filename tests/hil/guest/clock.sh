# The clock of the machine is set, an hour on and three back, while a stream is meshed and recorded: no frame is missed by
# limit: 120
# a subscriber that wants them all, no device is thought silent, and the recording plays to its end in the order of frames.
set -eu
. tests/daemon.sh
frames=60

cat >"$run/clock.yaml" <<YAML
socket: $run/mesh.sock
control_socket: $run/control.sock
streams:
  - name: box
    synthetic: {scene: moving-box, size: 64x48, noise: 0.002, fps: 10, frames: $frames, wait: 1}
    record: {path: $run/box.mcap, start: yes}
YAML
start_dexeld -c "$run/clock.yaml"
dexel cat --socket "$run/mesh.sock" --timeout 60 --quiet --stats >"$run/live.json" &
cat=$!
jump() { date -s "@$(($(date +%s) + $1))" >/dev/null; }
# seen N: until so many frames have been meshed
seen() {
  until dexel status --json --socket "$run/control.sock" | grep -Eo '"frames": ?[0-9]+' | grep -Eo '[0-9]+$' | awk -v n="$1" '{exit $1 < n}'; do :; done
}
seen 10
jump 3600
seen 25
jump -10800
wait "$cat"
dexel status --json --socket "$run/control.sock" >"$run/status.json"
stop_dexeld
grep -q "\"frame\": $((frames - 1))," "$run/live.json" || { echo "the subscriber: $(cat "$run/live.json")"; exit 1; }
dexel info "$run/box.mcap" >"$run/info" || { cat "$run/info"; exit 1; }
start_dexeld --replay "$run/box.mcap" --rate max --wait 1 --socket "$run/mesh.sock"
dexel cat --socket "$run/mesh.sock" --lossless --timeout 60 --quiet --stats >"$run/again.json"
stop_dexeld
grep -q "\"frame\": $((frames - 1))," "$run/again.json" || { echo "the replay: $(cat "$run/again.json")"; exit 1; }
digest() { grep -o '"digest": "[0-9a-f]*"' "$1"; }
[ "$(digest "$run/live.json")" = "$(digest "$run/again.json")" ] || { echo "the replay ends in another mesh"; exit 1; }
! grep -i "stalled\|silent" "$run/dexeld.log" || exit 1
jump 7200
