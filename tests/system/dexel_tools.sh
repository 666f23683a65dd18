#!/bin/sh
# dexel mesh, cat, render, status over one simulated sequence: the service and the offline tool give the same
# bytes, wrong input and usage give the promised exit status, and a failed write leaves nothing behind.
set -u
. "$(dirname "$0")/../expect.sh"

expect 0 "$dexel" sim hall -o seq --size 300x130 --frames 4 --noise 0.004 --dropouts 0.01 --attr 16
expect 0 "$dexel" mesh seq --stats -o last.ply
last=$(digest)
for key in regularity azimuth_step_deg elevation_step_deg; do
  grep -qE "\"$key\": -?[0-9]" out || fail "--stats without $key"
done
for options in '--encoding f32' '--encoding q16' '--encoding delta' '--threads 1' '--frame 3'; do
  # shellcheck disable=SC2086 # option and value
  expect 0 "$dexel" mesh seq --stats $options
  [ "$(digest)" = "$last" ] || fail "another mesh with $options"
done

expect 0 "$dexel" devices
expect 0 "$dexel" devices --json
grep -q '^{"devices":\[.*\]}$' out || fail 'devices --json is no object'
expect 2 "$dexel" devices more

start_dexeld --replay seq --rate max --wait 1 --socket "$run/mesh.sock" || exit 1
expect 0 "$dexel" cat --socket mesh.sock --lossless --encoding q16 --every -o every-%06d.ply --stats
[ "$(digest)" = "$last" ] || fail 'lossless cat ends with another mesh'
for n in 0 1 2 3; do
  "$dexel" mesh seq --frame $n -o "frame-$n.ply"
  cmp "frame-$n.ply" "every-00000$n.ply" || fail "frame $n differs"
done
for options in '--encoding f32' '--encoding q16' '--encoding delta --normals' '--encoding q16 --pull'; do
  # shellcheck disable=SC2086
  expect 0 "$dexel" cat --socket mesh.sock $options -o cat.ply
  cmp last.ply cat.ply || fail "late cat differs with $options"
done
expect 0 "$dexel" status --socket mesh.sock
grep -q '^replay  *ended ' out || fail 'status does not show the stream'
expect 0 "$dexel" status --socket mesh.sock --json
expect 1 "$dexel" cat --socket mesh.sock --stream other
ln -s mesh.sock alone.sock # no alone.sock.control beside it
began=$(date +%s)
expect 1 "$dexel" status --socket alone.sock
says 'this needs the control socket (control_socket in the configuration)'
[ $(($(date +%s) - began)) -lt 4 ] || fail 'status waited for a mesh socket'
stop_dexeld || fail 'dexeld failed'
expect 1 "$dexel" cat --socket mesh.sock
expect 1 "$dexel" status --socket mesh.sock

expect 0 "$dexel" render seq -o scan.png --size 320x160
expect 0 "$dexel" render last.ply -o mesh.png --size 320x160
cmp scan.png mesh.png || fail 'a scan and its mesh look different'
expect 0 "$dexel" render last.ply -o iso.png --size 320x160 --view iso --shade range --edges

expect 2 "$dexel" mesh seq
expect 2 "$dexel" mesh seq -o x.glb
expect 2 "$dexel" mesh seq --stats --tilt abc
says "dexel mesh: --tilt: found 'abc', expected degrees from 0 to 89"
expect 2 "$dexel" mesh seq --stats --paper
expect 2 "$dexel" cat --lossless --pull
expect 2 "$dexel" render seq -o x.jpg
expect 2 "$dexel" render last.ply -o x.png --frame 3
says "dexel render: --frame: found the mesh 'last.ply', expected a scan"
[ ! -e x.png ] || fail 'render wrote a picture all the same'
expect 2 "$dexel" nothing
for options in '--exact --encoding q16' '--exact --encoding delta' '--lod 2 --encoding q16' '--stride 4 --encoding delta'; do
  # shellcheck disable=SC2086 # words
  expect 2 "$dexel" mesh seq --stats $options
  says "dexel mesh: --encoding: found '"
done
for options in '--lod 2 --encoding q16' '--encoding delta --stride 4'; do
  # shellcheck disable=SC2086 # words
  expect 2 "$dexel" cat --socket mesh.sock $options
  says "dexel cat: --encoding: found '"
done
expect 2 "$dexel" bench nope
says "found 'nope', expected a benchmark (rules|update|lod|live|record|paper|quality) or stages of a frame (publish|"
expect 1 "$dexel" mesh none.ptx --stats
expect 1 "$dexel" mesh seq --frame 4 --stats
says 'seq: found 4 frames, expected one of number 4'
head -c 5000 seq/frame-000002.ptx >cut && mv cut seq/frame-000002.ptx
expect 1 "$dexel" mesh seq --stats
says frame-000002.ptx
expect 0 "$dexel" mesh seq --stats --frame 1

n_files=$(find . | wc -l)
(ulimit -f 16; expect 1 "$dexel" mesh seq --frame 1 -o full.ply; says 'full.ply: cannot be written'; exit $bad) || bad=1
[ "$(find . | wc -l)" = "$n_files" ] || fail 'a failed write left something behind'
exit $bad
