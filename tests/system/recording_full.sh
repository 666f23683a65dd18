#!/bin/sh
# A full disk while the daemon records (a small tmpfs): the mesh goes on, the error is told once, recording goes on
# when there is room, and the file tells of what is missing.
set -eu
. tests/daemon.sh
dexel=$B/bin/dexel
sock=$run/mesh.sock
disk=$run/disk
mkdir "$disk"
mount -t tmpfs -o size=12m tmpfs "$disk" 2>/dev/null || { echo "cannot mount a tmpfs"; exit 77; }
leave() {
  [ -z "$dexeld_pid" ] || stop_dexeld || true
  umount "$disk"
  at_exit
}
trap leave EXIT
wrong() { echo "$1"; cat "$run/dexeld.log"; exit 1; }
status() { "$dexel" record status --socket "$sock" --json; }
await() {
  tries=0
  until status | grep -q "$1"; do
    tries=$((tries + 1))
    [ $tries -lt 3000 ] || wrong "no $1: $(status)"
  done
}
# noise makes frames that differ: some 60 KB each
"$dexel" sim moving-box -o "$run/scan" --format pcd --size 80x60 --noise 0.002 --frames 8
head -c 11534336 /dev/zero >"$disk/ballast"
cat >"$run/c.yaml" <<YAML
socket: $sock
control_socket: $sock.control
streams:
  - name: scan
    file: {path: $run/scan, fps: 20, loop: yes}
    record: {path: "$disk/scan.mcap", compression: none, buffer_mib: 1}
YAML
start_dexeld -c "$run/c.yaml"
await '"dropped":[1-9].*"error_text":"No space left on device"'
"$dexel" cat --socket "$sock" --frames 20 --timeout 300 --quiet || wrong "the mesh has stopped"
"$B/tests/record_check" "$disk/scan.mcap" | grep -q '^blocks [1-9]' || wrong "while it waits"
rm "$disk/ballast"
tries=0
until grep -q 'recording goes on, [1-9][0-9]* blocks were lost' "$run/dexeld.log"; do
  tries=$((tries + 1))
  [ $tries -lt 100000 ] || wrong "recording does not go on: $(status)"
done
blocks() { status | sed 's/.*"blocks":\([0-9]*\).*/\1/'; }
before=$(blocks)
until [ "$(blocks)" -gt "$before" ]; do
  tries=$((tries + 1))
  [ $tries -lt 100000 ] || wrong "nothing more is recorded: $(status)"
done
stop_dexeld
[ "$(grep -c 'No space left' "$run/dexeld.log")" = 1 ] || wrong "the error was not told once"
# slowed down by a sanitizer it may be late for this disk, too
! "$B/tests/sanitized" || [ "$(grep -c 'blocks are lost' "$run/dexeld.log")" = 0 ] || wrong "told twice"
# what is missing and what the file tells are compared by record_check
"$B/tests/record_check" "$disk/scan.mcap" >"$run/out" || wrong "recording"
grep -q ' first 0 .* lost [1-9][0-9]* damages 0 ' "$run/out" || wrong "no gap: $(cat "$run/out")"
