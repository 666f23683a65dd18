#!/bin/sh
# Soak: 20,000 frames replayed at max to a lossless subscriber while others come and go; memory and
# descriptors stay flat.
set -eu
. tests/daemon.sh

rss() { sed -n 's/^VmRSS:[[:space:]]*\([0-9]*\) kB/\1/p' "/proc/$dexeld_pid/status"; }
fds() { ls "/proc/$dexeld_pid/fd" | wc -l; }

"$B/bin/dexel" sim hall -o "$run/scans" --format pcd --size 130x100 --noise 0.002 --frames 4
start_dexeld --replay "$run/scans" --rate max --loop --wait 1 --socket "$run/mesh.sock"
through() { "$B/bin/dexel" cat --socket "$run/mesh.sock" --quiet "$@"; }
through --lossless --encoding q16 --frames 2000
before=$(rss) n=$(fds)
through --lossless --encoding q16 --frames 20000 &
main=$!
while kill -0 $main 2>/dev/null; do
  through --encoding f32 --frames 20
  through --encoding q16 --pull --frames 20
done
wait $main
after=$(rss)
echo "resident $before kB, then $after kB; descriptors $n, then $(fds)"
[ "$after" -le $((before + 4096)) ]
# the last client's descriptor goes when the loop has seen it go: ask the loop
"$B/bin/dexel" status --socket "$run/mesh.sock" >/dev/null
[ "$(fds)" -le "$n" ]
stop_dexeld
