#!/bin/sh
# A service of one's own under `dexel bench live`, a fresh one for each table:
#   tests/bench/live.sh [--json|--markdown]    (--json: an object a table)
# latency of a camera at 30 frames a second, alone and with 50 subscribers, and what each stage adds; how many
# subscribers it serves when some 2 % of the tiles change in a frame, and when all do.
set -eu
. tests/daemon.sh
format=${1:-}
seconds=${SECONDS_EACH:-2} latency_seconds=${LATENCY_SECONDS:-5}

serve() { # STREAM-KEYS
  cat >"$run/live.yaml" <<Y
socket: $run/mesh.sock
control_socket: $run/control.sock
streams:
  - name: live
$1
Y
  start_dexeld -c "$run/live.yaml"
}

measure() { # ARGUMENTS of dexel bench live; in Markdown the tables alone
  status=0
  # shellcheck disable=SC2086 # none or one
  "$B/bin/dexel" bench live --socket "$run/mesh.sock" --seconds "$seconds" $format "$@" >"$run/out" || status=$?
  if [ "$format" = --markdown ]; then sed -n '/^|/p; /^$/p' "$run/out" | cat -s; else cat "$run/out"; fi
  return $status
}

head_line() { # TITLE TEXT
  case $format in
    --json) ;;
    --markdown) printf '### %s\n\n%s\n' "$1" "$2" ;;
    *) printf '== %s\n%s\n\n' "$1" "$2" ;;
  esac
}

box='    synthetic: {scene: moving-box, size: 640x480, fps: 30}'
all='    synthetic: {scene: moving-box, size: 640x480, fps: 30, dropouts: 0.005}'
still='    synthetic: {scene: hall, size: 640x480, fps: 30, noise: 0.005}
    ingest: {filter: mean, hold: 1.18}'

for n in 1 50; do
  head_line "Latency, a box that moves, $n subscribed" \
    "640x480 at 30 Hz without noise, delta: tiles change where the box goes."
  serve "$box"
  measure --control "$run/control.sock" --subscribers $n --seconds "$latency_seconds"
  stop_dexeld
done

# beside_recorder NAME KEYS: scans from files, which are blocks large enough to be worth recording
beside_recorder() {
  head_line "Latency, scans of 1.2 MB, $1" \
    "320x240 at 30 Hz from PCD files, 37 MB/s that can be recorded, delta, one subscriber."
  serve "    file: {path: $run/scans, fps: 30, loop: yes}
    record: {$2, split_mib: 64, keep_mib: 512}"
  measure --control "$run/control.sock" --seconds "$latency_seconds"
  stop_dexeld
}
"$B/bin/dexel" sim moving-box -o "$run/scans" --format pcd --size 320x240 --noise 0.001 --frames 30
beside_recorder 'not recorded' 'path: ""'
beside_recorder 'recorded' "path: $run/none.mcap, compression: none"
beside_recorder 'recorded with zstd' "path: $run/zstd.mcap"

for n in 1 50; do
  head_line "Latency, every tile changes, $n subscribed" "640x480 at 30 Hz with drop-outs that come and go, q16."
  serve "$all"
  measure --control "$run/control.sock" --encoding q16 --subscribers $n --seconds "$latency_seconds"
  stop_dexeld
done
head_line "Subscribers, some 2 % of the tiles change" \
  "A hall that stands still, 640x480 at 30 Hz with 5 mm of noise, filter mean, delta."
serve "$still"
measure --subscribers 1,1,10,50,100,200
stop_dexeld
head_line "Subscribers, every tile changes" "640x480 at 30 Hz with drop-outs that come and go, q16."
serve "$all"
measure --encoding q16 --subscribers 1,5,10,20,30,40,50,75,100
stop_dexeld
