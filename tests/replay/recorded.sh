#!/bin/sh
# Real scans recorded by the daemon: the recording alone gives the golden mesh again, at max and at real time, and
# its last frame after a seek.
set -eu
. tests/daemon.sh
[ -d "${DEXEL_DATA:-}" ] || { echo "no scans at DEXEL_DATA=${DEXEL_DATA:-}"; exit 77; }
wrong() { echo "$1"; cat "$run/dexeld.log"; exit 1; }
sock=$run/mesh.sock

# read_mesh OPTIONS: of the stream, to its end; leaves $got
read_mesh() {
  "$B/bin/dexel" cat --socket "$sock" --stats --quiet "$@" >"$run/cat.json"
  stop_dexeld
  got=$(sed -n 's/.*"digest": "\([0-9a-f]*\)".*/\1/p' "$run/cat.json")
}
expect() { [ "$got" = "$1" ] || wrong "$2: digest $got, expected $1"; }

# record PATH SIGMA: into $run/recorded*.mcap, the mesh into $got
record() {
  rm -f "$run"/recorded*.mcap
  cat >"$run/c.yaml" <<YAML
socket: $sock
control_socket: $sock.control
streams:
  - name: scan
    file: {path: "$1", rate: max, lossless: yes, wait: 1}
    mesh: {sigma: $2}
    record: {path: $run/recorded.mcap, split_mib: 8}
YAML
  start_dexeld -c "$run/c.yaml"
  read_mesh --lossless
}

while read -r want file; do
  scan=$DEXEL_DATA/$file
  [ -e "$scan" ] || { echo "$scan is not there"; exit 77; }
  record "$scan" auto
  expect "$want" "$file, first run"
  start_dexeld --replay "$run/recorded*.mcap" --rate max --socket "$sock"
  read_mesh --lossless
  expect "$want" "$file, replayed at max"
  start_dexeld --replay "$run/recorded*.mcap" --wait 1 --socket "$sock"
  read_mesh
  expect "$want" "$file, replayed at real time"
done <tests/replay/scans.golden

# a sequence: its last frame, after the first and gone to at once
mkdir "$run/sequence"
for n in 0 1; do ln -s "$(realpath "$DEXEL_DATA/pcd/grabber-00$n.pcd")" "$run/sequence"; done
record "$run/sequence" '[0.0002, 0, 0.0016]'
want=$got
start_dexeld --replay "$run/recorded*.mcap" --rate max --socket "$sock"
read_mesh --lossless
expect "$want" "sequence, replayed at max"
start_dexeld --replay "$run/recorded*.mcap" --rate max --socket "$sock"
"$B/bin/dexel" replay seek 1e6 --socket "$sock" >"$run/out"
read_mesh --lossless
expect "$want" "sequence, after a seek to its end"
grep -q '"commits": 1,' "$run/cat.json" || wrong "the seek played more than the last frame: $(cat "$run/cat.json")"
