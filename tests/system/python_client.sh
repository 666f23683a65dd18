#!/bin/sh
# The client in Python (client/python/dexel.py) holds the mesh that libdexel holds, after every COMMIT: of each model of
# geometry, in each encoding, with numpy and without; and no server makes it hang or fall over (python_client.py).
set -eu
. tests/daemon.sh
dexel=$B/bin/dexel
wrong() { echo "$1"; exit 1; }

# the first one that has numpy, else the first
python=
for p in python3 /usr/bin/python3; do
  "$p" -c 'import sys; sys.exit(sys.version_info < (3, 9))' 2>/dev/null || continue
  [ -n "$python" ] || python=$p
  ! "$p" -c 'import numpy' 2>/dev/null || { python=$p; numpy=yes; break; }
done
[ -n "$python" ] || { echo "there is no python3 of version 3.9 or newer"; exit 77; }
[ -n "${numpy:-}" ] || echo "numpy is not there: only the way without it is tested"
export PYTHONPATH=client/python PYTHONDONTWRITEBYTECODE=1
testing() { timeout 300 "$python" tests/system/python_client.py "$@"; }

testing worked
testing lies
testing passing

# A pinhole camera with a box that moves before a still room; a full turn with all sides of struts, normals and smoothed
# ranges; one with polar caps; one narrower than a tile's block; beams that follow no model, in ranges of 32 bits; a scan's
# own points. The noise is such that the four predictors of delta occur: planar and median in the first two, mean in the
# third, left in the fourth.
"$dexel" sim moving-box -o "$run/box" --format pcd --size 150x140 --noise 0 --dropouts 0.001 --frames 4
"$dexel" sim hall -o "$run/hall.pcd" --size 140x100 --noise 0.002 --dropouts 0.15
"$dexel" sim hall -o "$run/small.pcd" --size 80x68 --noise 0.002 --dropouts 0.03
"$dexel" sim sphere -o "$run/sphere.pcd" --size 90x46 --unit 0.0001 --noise 0.02 --attr 16
"$dexel" sim hall -o "$run/narrow.pcd" --size 60x20 --noise 0.003 --dropouts 0.05 --attr 0
testing table "$run/table.pcd"
numpy_too=${numpy:+numpy}
subscribers() { # subscribers NAME: encoding and way of each, one a line
  case $1 in
  table) encodings='f32 delta' ;;
  exact) encodings=f32 ;;
  *) encodings='f32 q16 delta' ;;
  esac
  for e in $encodings; do
    for way in lists $numpy_too; do echo "$e $way"; done
  done
}
cat >"$run/dexeld.yaml" <<YAML
socket: $run/mesh.sock
control_socket: $run/mesh.sock.control
streams:
  - name: box
    file: {path: $run/box, rate: max, lossless: yes, wait: $((1 + $(subscribers box | wc -l)))}
  - name: hall
    file: {path: $run/hall.pcd, rate: max, lossless: yes, wait: $((1 + $(subscribers hall | wc -l)))}
    mesh: {normals: yes, smooth: yes, bridge: 2}
  - name: sphere
    file: {path: $run/sphere.pcd, rate: max, lossless: yes, wait: $((1 + $(subscribers sphere | wc -l)))}
    mesh: {caps: yes}
  - name: narrow
    file: {path: $run/narrow.pcd, rate: max, lossless: yes, wait: $((1 + $(subscribers narrow | wc -l)))}
  - name: table
    file: {path: $run/table.pcd, rate: max, lossless: yes, unit: 1e-6, wait: $((1 + $(subscribers table | wc -l)))}
    mesh: {normals: yes}
  - name: exact
    file: {path: $run/table.pcd, rate: max, lossless: yes, exact: yes, wait: $((1 + $(subscribers exact | wc -l)))}
  - name: lod
    file: {path: $run/box, rate: max, lossless: yes, wait: 2}
  - name: tiles-0
    file: {path: $run/box, rate: max, lossless: yes, wait: 1}
  - name: tiles-1
    file: {path: $run/box, rate: max, lossless: yes, wait: 1}
  - name: damage
    file: {path: $run/small.pcd, rate: max, lossless: yes, wait: 1}
    mesh: {normals: yes}
YAML
start_dexeld -c "$run/dexeld.yaml"

client() { # client lists|numpy OPTION...; without site-packages there is no numpy
  way=$1
  shift
  case $way in
  lists) timeout 300 "$python" -S client/python/dexel.py --socket "$run/mesh.sock" --lossless --every "$@" ;;
  numpy) timeout 300 "$python" client/python/dexel.py --socket "$run/mesh.sock" --lossless --every "$@" ;;
  esac
}
# follow NAME LIBDEXEL-PID: waits for it and for $pids, which must have written the same meshes
follow() {
  wait "$2" || wrong "$1: dexel cat failed"
  for pid in $pids; do wait "$pid" || wrong "$1: the client failed"; done
  for mesh in "$run/$1"-cat-*.ply; do testing same "$mesh" "$run/$1"-python-*-"${mesh##*-}"; done
}
for name in box hall sphere narrow table exact; do
  "$dexel" cat --socket "$run/mesh.sock" --stream $name --lossless --normals --every -o "$run/$name-cat-%06d.ply" --quiet &
  cat_pid=$!
  pids=
  subscribers $name >"$run/subscribers"
  while read -r encoding way; do
    client "$way" --stream $name --encoding "$encoding" --normals -o "$run/$name-python-$encoding-$way-%06d.ply" --quiet 2>"$run/$name-$encoding-$way.log" &
    pids="$pids $!"
  done <"$run/subscribers"
  follow $name $cat_pid
  meshes=$(find "$run" -name "$name-python-*.ply" | wc -l)
  expected=$(find "$run" -name "$name-cat-*.ply" | wc -l)
  [ "$meshes" = $((expected * $(wc -l <"$run/subscribers"))) ] || wrong "$name: $meshes meshes, libdexel took $expected"
  grep -q '^ended$' "$run/$name-f32-lists.log" || wrong "$name: $(cat "$run/$name-f32-lists.log")"
done
[ "$(find "$run" -name "box-cat-*.ply" | wc -l)" = 4 ] || wrong "the box has other meshes than four"

# levels of detail
"$dexel" cat --socket "$run/mesh.sock" --stream lod --lossless --lod 2.5 --every -o "$run/lod-cat-%06d.ply" --quiet &
cat_pid=$!
client "${numpy_too:-lists}" --stream lod --lod 2.5 -o "$run/lod-python-f32-%06d.ply" >"$run/lines" 2>/dev/null &
pids=$!
follow lod $cat_pid
[ "$(grep -c '^epoch [0-9]*, frame [0-9]*: [0-9]* tiles changed, [1-9][0-9]* triangles$' "$run/lines")" = 4 ] || wrong "$(cat "$run/lines")"

testing tiles "$run/mesh.sock" tiles-0 tiles-1
testing damage "$run/mesh.sock" damage

# a region, of a replay that is over
"$python" client/python/dexel.py --socket "$run/mesh.sock" --stream box --region 1,1,1,9 >"$run/lines" 2>/dev/null
grep -q '^epoch [0-9]*, frame 3: 2 tiles changed, ' "$run/lines" || wrong "a region: $(cat "$run/lines")"

# names of files as dexel cat makes them
for out in 'odd%s%d.ply' '%06d-of-%06d.PLY' 'a.b/plain.ply'; do
  mkdir -p "$run/by-cat/a.b" "$run/by-python/a.b"
  "$dexel" cat --socket "$run/mesh.sock" --stream box --every --frames 1 -o "$run/by-cat/$out" --quiet
  timeout 300 "$python" client/python/dexel.py --socket "$run/mesh.sock" --stream box --every --frames 1 -o "$run/by-python/$out" >/dev/null 2>&1 ||
    wrong "-o '$out': it failed"
done
names=$(cd "$run/by-cat" && find . -type f | sort)
[ "$(echo "$names" | wc -l)" = 3 ] || wrong "files of dexel cat: $names"
[ "$(cd "$run/by-python" && find . -type f | sort)" = "$names" ] || wrong "other files than $names: $(find "$run/by-python" -type f)"

# what it says where something is not there
"$python" client/python/dexel.py --socket "$run/mesh.sock" --list >"$run/list"
grep -q '^sphere ended' "$run/list" || wrong "$(cat "$run/list")"
refused() { # refused TEXT OPTION...
  text=$1
  shift
  code=0
  timeout 300 "$python" client/python/dexel.py "$@" >"$run/out" 2>"$run/err" || code=$?
  [ $code = 1 ] || wrong "$*: status $code"
  grep -q -- "$text" "$run/err" || wrong "$*: $(cat "$run/err")"
}
refused '(no such stream, 3)' --socket "$run/mesh.sock" --stream attic
refused '(encoding, 4)' --socket "$run/mesh.sock" --stream exact --encoding q16
refused '(encoding, 4)' --socket "$run/mesh.sock" --stream lod --encoding delta --stride 4
refused 'dexel.py: .*/nothing.sock: No such file or directory$' --socket "$run/nothing.sock"
refused 'this seems to be the control socket' --socket "$run/mesh.sock.control"
misused() { # misused TEXT OPTION...
  text=$1
  shift
  code=0
  timeout 300 "$python" client/python/dexel.py --socket "$run/mesh.sock" --stream box "$@" >"$run/out" 2>"$run/err" || code=$?
  [ $code = 2 ] || wrong "$*: status $code"
  [ "$(wc -l <"$run/err")" = 1 ] && grep -q "^dexel.py: $text" "$run/err" || wrong "$*: $(cat "$run/err")"
}
misused "--frames: found '0', expected commits from 1 " --frames 0
misused "--frames: found '-3', expected commits from 1 " --frames -3
misused "--region: found 'a', expected R,C,ROWS,COLS" --region a
misused "--region: found '0,0,1', expected R,C,ROWS,COLS" --region 0,0,1
misused "--region: found '0,0,0,1', expected R,C,ROWS,COLS" --region 0,0,0,1
misused "--lod: found 'nan', expected sigmas from 0.0625 to 4095.875" --lod nan
misused "--stride: found '3', expected 2|4|8|16|32|64" --stride 3
misused "--encoding: found 'f16', expected f32|q16|delta" --encoding f16
misused "--timeout: found '0', expected seconds from 0.001" --timeout 0
misused "-o: found 'mesh.stl', expected a name that ends in .ply" -o mesh.stl
misused '--every needs -o' --every
misused '--lossless and --pull do not go together' --lossless --pull
stop_dexeld

# The service goes and comes back: so does the mesh. The pipe's lines are the events.
cat >"$run/live.yaml" <<YAML
socket: $run/mesh.sock
control_socket: $run/control.sock
streams:
  - name: box
    synthetic: {scene: moving-box, size: 64x48}
YAML
start_dexeld -c "$run/live.yaml"
timeout 300 "$python" client/python/dexel.py --socket "$run/mesh.sock" --pull --frames 3 >"$run/lines" 2>/dev/null
[ "$(grep -c 'triangles$' "$run/lines")" = 3 ] || wrong "pull: $(cat "$run/lines")"
refused 'this seems to be the mesh socket' --list --socket "$run/mesh.sock"
mkfifo "$run/events"
testing restart "$run/mesh.sock" >"$run/events" &
client_pid=$!
exec 8<"$run/events"
read -r line <&8 && [ "$line" = 'fresh 1' ] || wrong "$line"
stop_dexeld
start_dexeld -c "$run/live.yaml"
read -r line <&8 && [ "$line" = 'fresh 2' ] || wrong "$line"
wait $client_pid
stop_dexeld

# the program says that it waits, and why
timeout 300 "$python" client/python/dexel.py --socket "$run/mesh.sock" --wait --frames 2 --quiet 2>"$run/events" &
client_pid=$!
exec 8<"$run/events"
read -r line <&8 && [ "$line" = "gone: $run/mesh.sock: No such file or directory" ] || wrong "$line"
start_dexeld -c "$run/live.yaml"
wait $client_pid || wrong 'it did not go on'
stop_dexeld
