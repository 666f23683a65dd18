#!/bin/sh
# A simulated SCIP scanner on a turning stage, through the daemon to a subscriber: by TCP the mesh lies on the
# walls that the scanner sees, and its recording replays to the same meshes; by a pty damage and trouble are got over,
# and after an unplug the stream returns.
set -eu
. tests/daemon.sh
dexel=$B/bin/dexel
sock=$run/mesh.sock
sim_pid=
wrong() { echo "$1"; cat "$run/dexeld.log"; exit 1; }
stop_sim() {
  [ -z "$sim_pid" ] || { kill "$sim_pid" 2>/dev/null || true; wait "$sim_pid" 2>/dev/null || true; }
  sim_pid=
}
trap 'stop_sim; at_exit' EXIT
# start_sim ARGS...: returns when it is there; $said is what it said
start_sim() {
  rm -f "$run/sim"
  mkfifo "$run/sim"
  "$B/tests/scip_sim" "$@" >"$run/sim" &
  sim_pid=$!
  read -r said <"$run/sim" || wrong "no simulator: $*"
}
status() { "$dexel" status --socket "$sock.control" --json; }
# await TEXT: until the status has it
await() {
  tries=0
  until status | grep -q -- "$1"; do
    tries=$((tries + 1))
    [ $tries -lt 6000 ] || wrong "status never said $1: $(status)"
  done
}
field() { sed "s/.*\"$1\": \"\{0,1\}\([0-9a-z]*\).*/\1/" "$2"; }
# config KEYS-OF-HOKUYO STAGE MORE-OF-STREAM
config() {
  cat <<YAML
socket: $sock
control_socket: $sock.control
streams:
  - name: turret
    commit_ms: 60000
    hokuyo: {$1, stage: {$2}}
    mesh: {sigma: 0.01}
    $3
YAML
}

# ---- TCP: where the points are; and the recording
mount='--rpm 30 --offset 0.1,0.02,0.3 --angles 0,10,0'
start_sim --tcp 0 $mount
config "tcp: '127.0.0.1:$said'" 'rpm: 30, columns: 60, exact: yes, offset: [0.1, 0.02, 0.3], angles: [0, 10, 0]' \
  "record: {path: $run/tcp.mcap}" >"$run/tcp.yaml"
start_dexeld -c "$run/tcp.yaml"
"$dexel" cat --socket "$sock" --frames 3 -o "$run/live.obj" --stats --quiet >"$run/live.json"
stop_dexeld
stop_sim
# the simulator's room; the farthest point from its walls, in millimetres. A millisecond of the clocks is 0.18 degrees
awk '
  BEGIN {split("-3 -2.5 -1.2 4 2 1.6", wall, " ")}
  /^v / {
    near = 1e9; n++
    for (k = 1; k <= 6; k++) {d = $(2 + (k - 1) % 3) - wall[k]; d = d < 0 ? -d : d; if (d < near) near = d}
    if (near > worst) worst = near
  }
  END {printf "%d points, worst %.1f mm\n", n, 1000 * worst; exit !(n > 43000 && worst < 0.04)}
' "$run/live.obj" || wrong "the mesh is not the room"
frame=$(field frame "$run/live.json")
start_dexeld --replay "$run/tcp.mcap" --rate max --socket "$sock"
"$dexel" cat --socket "$sock" --lossless --frames $((frame + 1)) --stats --quiet >"$run/replay.json"
stop_dexeld
[ "$(field frame "$run/replay.json")" = "$frame" ] || wrong "replay: $(cat "$run/replay.json")"
[ "$(field digest "$run/replay.json")" = "$(field digest "$run/live.json")" ] ||
  wrong "the replay differs: $(cat "$run/live.json" "$run/replay.json")"

# ---- a pty: damage of every kind, in small pieces
config "tty: $run/tty" 'rpm: 60, sweep: half, angles: [0, 90, 0]' '' >"$run/pty.yaml"
start_sim --pty "$run/tty" --model urg-04lx --rpm 60 --angles 0,90,0 --stale --split 17 --bad-sum 5 --drop 20011 --codes 50
start_dexeld -c "$run/pty.yaml"
"$dexel" cat --socket "$sock" --frames 4 --stats --quiet >"$run/damaged.json"
grep -q '"frames_missed": 0' "$run/damaged.json" || wrong "damaged: $(cat "$run/damaged.json")"
await '"damaged":[1-9]'
status | grep -q '"opens":1' || wrong "damage is no reason to open it anew: $(status)"
status | grep -q '"serial":"H0614967"' || wrong "$(status)"

# ---- unplugged in the middle of a scan, and there again
stop_sim
await '"state":"gone"'
start_sim --pty "$run/tty" --model urg-04lx --rpm 60 --angles 0,90,0
await '"opens":2'
"$dexel" cat --socket "$sock" --frames 2 --stats --quiet >"$run/again.json"
status | grep -q '"unplugged":1' || wrong "$(status)"
stop_dexeld
stop_sim

# ---- troubles that the scanner tells, each over after a while
config "tty: $run/tty" 'rpm: 60' '' >"$run/trouble.yaml"
start_sim --pty "$run/tty" --rpm 60 --suspend 20,240 # six seconds: longer than a silent device is waited for
start_dexeld -c "$run/trouble.yaml"
await '"trouble":"measurement suspended by the scanner: status 21"'
await '"state":"streaming".*"trouble":""'
status | grep -q '"opens":1' || wrong "a scanner that says that it pauses is no fault: $(status)"
stop_dexeld
stop_sim
start_sim --pty "$run/tty" --rpm 60 --fault 20
start_dexeld -c "$run/trouble.yaml"
await '"trouble":"hardware fault: status 51"'
await '"state":"streaming".*"trouble":""'
status | grep -q '"opens":1' || wrong "a fault is reset on the open link: $(status)"
stop_dexeld
