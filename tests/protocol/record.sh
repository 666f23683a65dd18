#!/bin/sh
# Records the connections of tests/protocol/cases as they are today: sh tests/protocol/record.sh tests/protocol/1.1
# A version's folder is made once, when it is declared, and never again: later programs are held to it (tests/system/protocol.sh).
# The scans are kept too, or made when they are not there.
set -eu
out=$(mkdir -p "$1" && cd "$1" && pwd)
. tests/daemon.sh
B=$(cd "$B" && pwd)
here=$(pwd)
dexel=$B/bin/dexel

if [ ! -d "$out/scans" ]; then
  mkdir "$out/scans"
  cd "$out/scans"
  "$dexel" sim hall -o room --format pcd --size 72x8 --noise 0.002 --dropouts 0.1 --frames 2
  "$dexel" sim moving-box -o box --format pcd --size 70x12 --noise 0.003 --frames 3 --attr 16
  "$dexel" sim sphere -o sphere.pcd --size 40x12 --noise 0.02 --attr 0
  mkdir steps
  "$dexel" sim hall -o steps/1.pcd --size 40x6 --noise 0.01 --attr 0
  "$dexel" sim hall -o steps/2.pcd --size 20x12 --noise 0.01 --attr 0
  PYTHONPATH=$here/client/python PYTHONDONTWRITEBYTECODE=1 python3 "$here/tests/system/python_client.py" table table.pcd 30 20
fi
cp -r "$out/scans/." "$run"
cp "$out/dexeld.yaml" "$run"
cd "$run"
grep -v '^#' "$here/tests/protocol/cases" | while read -r name words; do
  # shellcheck disable=SC2086 # words
  "$B/tests/recorded" say "$out/$name.client" $words
  start_dexeld -c dexeld.yaml
  "$B/tests/recorded" take mesh.sock "$out/$name.client" "$out/$name.server"
  kill "$dexeld_pid" 2>/dev/null || true
  wait "$dexeld_pid" || true
  dexeld_pid=
  "$B/tests/recorded" meshes "$out/$name.client" "$out/$name.server" >"$out/$name.meshes"
done
