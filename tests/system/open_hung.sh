#!/bin/sh
# A source that does not open (tests/faults; in the field a disk on the network): the log names it, at a start SIGTERM ends the
# service all the same, and a reload that waits for it harms neither the streams that there are nor whoever asks for another.
set -u
. tests/configured.sh

# config [FILE]: a stream `box`, and one that replays the file
config() {
  printf 'socket: %s\ncontrol_socket: %s.control\nstreams:\n' "$sock" "$sock"
  printf '  - {name: box, synthetic: {scene: moving-box, size: 64x48, fps: 20}}\n'
  for file; do printf '  - {name: scan, file: {path: %s}}\n' "$file"; done
}
# logged TEXT: it comes, if it is not there yet
logged() { timeout 300 tail -n +1 -f "$run/dexeld.log" | grep -qF -m 1 -- "$1" || wrong "the log does not tell: $1"; }

"$dexel" sim sphere -o "$run/scan.pcd" --size 24x16 || exit 1
mkdir "$run/bin"
ln -s "$(realpath "$B/tests/dexeld_faults")" "$run/bin/dexeld" # where start_dexeld looks for it
B=$run
export DEXELD_FAULT=hang-open:2

# ---- at a start
config "$run/scan.pcd" >"$yaml"
"$B/bin/dexeld" -c "$yaml" 2>"$run/dexeld.log" &
dexeld_pid=$!
logged "service: still opening stream scan: $run/scan.pcd"
stop_dexeld || wrong "status $dexeld_status when it was stopped at its start"
logged "service: stopping: stream scan: $run/scan.pcd: still being opened, not waited for"
[ ! -e "$sock" ] || wrong "its socket is left"

# ---- at a reload
rm "$run/dexeld.log"
config >"$yaml"
start_dexeld -c "$yaml" || exit 1
config "$run/scan.pcd" >"$yaml"
timeout 300 "$dexel" reload --socket "$sock" >"$run/first" 2>&1 &
first=$!
logged "reload: still opening stream scan: $run/scan.pcd"
code=0
timeout 300 "$dexel" reload --socket "$sock" >"$run/said" 2>&1 || code=$?
[ $code = 1 ] || wrong "a second reload: status $code, expected 1"
grep -qxF "dexel reload: $sock.control: the service: a reload is under way (stream scan)" "$run/said" || wrong "a second reload said '$(cat "$run/said")'"
timeout 300 "$dexel" cat --socket "$sock" --stream box --frames 2 --quiet || wrong "no mesh of box"
stop_dexeld || wrong "status $dexeld_status at the end"
wait $first && wrong "the first reload is told as done: $(cat "$run/first")"
[ ! -e "$sock" ] || wrong "its socket is left"
exit $bad
