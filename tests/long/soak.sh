#!/bin/sh
# Soak: a recording looped at max, every frame of it to a lossless subscriber while others come and go in all encodings;
# memory, descriptors and threads stay flat: no more is mapped after it than before. What is resident may grow within that,
# as memory for meshes and clients that was taken at the start is used for the first time.
# SOAK_FRAMES=2000000 is the endurance run of docs/operations.md.
set -eu
. tests/daemon.sh
frames=${SOAK_FRAMES:-200000}
dexel=$B/bin/dexel

kb() { sed -n "s/^$1:[[:space:]]*\([0-9]*\) kB/\1/p" "/proc/$dexeld_pid/status"; }
fds() { ls "/proc/$dexeld_pid/fd" | wc -l; }
threads() { ls "/proc/$dexeld_pid/task" | wc -l; }
through() { "$dexel" cat --socket "$run/mesh.sock" --quiet "$@"; }
# the last client's descriptor goes when the loop has seen it go: ask the loop
settle() { "$dexel" status --socket "$run/mesh.sock.control" >/dev/null; }

"$dexel" sim moving-box -o "$run/scans" --format pcd --size 64x48 --noise 0.002 --dropouts 0.01 --frames 50
"$dexel" convert "$run/scans" "$run/scan.mcap"
start_dexeld --replay "$run/scan.mcap" --rate max --loop --wait 1 --socket "$run/mesh.sock"
through --lossless --encoding q16 --frames 5000
settle
before=$(kb VmData) resident=$(kb VmRSS) n_fds=$(fds) n_threads=$(threads)
through --lossless --encoding q16 --frames "$frames" --stats >"$run/stats" &
main=$!
n_clients=0
while kill -0 $main 2>/dev/null; do
  through --encoding f32 --frames 20
  through --encoding q16 --pull --frames 20
  through --encoding delta --frames 20
  n_clients=$((n_clients + 3))
done
wait $main
settle
after=$(kb VmData)
echo "$frames frames, $n_clients other clients: mapped $before kB, then $after kB; resident $resident kB, then $(kb VmRSS) kB; descriptors $n_fds, then $(fds);" \
  "threads $n_threads, then $(threads)"
grep -q "\"commits\": $frames," "$run/stats"
[ "$after" -le $((before + 1024)) ]
[ "$(fds)" -le "$n_fds" ]
[ "$(threads)" -eq "$n_threads" ]
stop_dexeld
