#!/bin/sh
# Connections that were recorded when a version of the protocol was declared (tests/protocol): today's libdexel and dexel.py make the
# same meshes of what the service said then, libdexel says what the client said then, and today's service gives that
# client the same answers, message by message, and the same meshes.
set -eu
. tests/daemon.sh
B=$(cd "$B" && pwd)
here=$(pwd)
recorded=$B/tests/recorded
wrong() { echo "$1"; exit 1; }

python=
for p in python3 /usr/bin/python3; do
  "$p" -c 'import sys; sys.exit(sys.version_info < (3, 9))' 2>/dev/null || continue
  [ -n "$python" ] || python=$p
  ! "$p" -c 'import numpy' 2>/dev/null || { python=$p; break; }
done
[ -n "$python" ] || echo "there is no python3 of version 3.9 or newer: dexel.py is not tested"
export PYTHONPATH="$here/client/python" PYTHONDONTWRITEBYTECODE=1

n=0
for folder in tests/protocol/*/; do
  folder=$here/$folder
  cp -r "$folder/scans/." "$run"
  cp "$folder/dexeld.yaml" "$run"
  cd "$run"
  [ -z "$python" ] || "$python" "$here/tests/system/recorded.py" "$run" "$folder"/*.client || wrong "dexel.py failed"
  for said in "$folder"/*.client; do
    heard=${said%.client}.server expected=${said%.client}.meshes name=$(basename "$said" .client)
    "$recorded" meshes "$said" "$heard" >meshes || wrong "$name: $(cat meshes)"
    diff "$expected" meshes || wrong "$name: < the meshes of then, > those of libdexel"
    if [ -n "$python" ]; then
      # it stops at the stream's end, and tells neither streams nor resets
      sed -e '/^stream/d' -e '/^reset/d' -e '/^ended/q' "$expected" >lines
      diff lines "$name.meshes" || wrong "$name: < the meshes of then, > those of dexel.py"
    fi

    start_dexeld -c dexeld.yaml
    "$recorded" take mesh.sock "$said" now || wrong "$name: the service does not answer as then"
    # who was refused did not make it quit
    ! grep -q '^ended' "$expected" || { wait "$dexeld_pid" || wrong "$name: the service did not quit"; dexeld_pid=; }
    [ -z "$dexeld_pid" ] || stop_dexeld
    "$recorded" same "$heard" now || wrong "$name: other messages than then"
    "$recorded" meshes "$said" now >meshes || wrong "$name: $(cat meshes)"
    diff "$expected" meshes || wrong "$name: < the meshes of then, > those of today's service"
    n=$((n + 1))
  done
  cd "$here"
done
[ $n -ge 15 ] || wrong "found $n connections"
