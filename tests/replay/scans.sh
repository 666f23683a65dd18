#!/bin/sh
# Real scans through the service: replayed at max to a lossless subscriber, in every encoding, the file that
# `dexel cat` writes is that of `dexel mesh`, byte for byte, and its digest is the golden one.
set -eu
. tests/daemon.sh
[ -d "${DEXEL_DATA:-}" ] || { echo "no scans at DEXEL_DATA=${DEXEL_DATA:-}"; exit 77; }

digest() { sed -n 's/.*"digest": "\([0-9a-f]*\)".*/\1/p' "$1"; }

while read -r want file; do
  scan=$DEXEL_DATA/$file
  [ -e "$scan" ] || { echo "$scan is not there"; exit 77; }
  "$B/bin/dexel" mesh "$scan" -o "$run/mesh.ply" --stats >"$run/mesh.json"
  for encoding in f32 q16 delta; do
    start_dexeld --replay "$scan" --rate max --socket "$run/mesh.sock"
    "$B/bin/dexel" cat --socket "$run/mesh.sock" --lossless --encoding $encoding \
      -o "$run/cat.ply" --stats --quiet >"$run/cat.json"
    stop_dexeld
    cmp "$run/mesh.ply" "$run/cat.ply"
    for json in mesh cat; do
      got=$(digest "$run/$json.json")
      [ "$got" = "$want" ] || { echo "$file, $json, $encoding: digest $got, expected $want"; exit 1; }
    done
  done
done <tests/replay/scans.golden
