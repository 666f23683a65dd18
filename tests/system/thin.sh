#!/bin/sh
# Scans thinned into an array of chosen size: by dexel mesh, convert and render, and by the service, which gives the same
# bytes; wrong use is refused with words. And the paper's table in small.
set -u
. "$(dirname "$0")/../expect.sh"

expect 0 "$dexel" sim hall -o scan.pcd --size 600x400 --noise 0.002 --attr 16
expect 0 "$dexel" mesh scan.pcd --stats
own=$(digest)
points=$(number points) triangles=$(number triangles)

# At its own size the array is the scan's own grid, with every sample.
expect 0 "$dexel" mesh scan.pcd --size 600x400 --stats
[ "$(number points) $(number triangles)" = "$points $triangles" ] ||
  fail "$(number points) points, $(number triangles) triangles at the scan's own size, expected $points, $triangles"

# Smaller: one sample a dexel, whatever is kept; the seam stays closed.
for keep in centre nearest median mean first; do
  expect 0 "$dexel" mesh scan.pcd --size 200x130 --keep $keep --stats
  [ "$(number points)" -gt 25500 ] && [ "$(number points)" -le 26000 ] ||
    fail "$keep: $(number points) points in the mesh, expected nearly all 26000"
  grep -q '"wrap": true' out || fail "$keep: an open seam"
  digest >"digest.$keep"
  [ "$(digest)" != "$own" ] || fail "$keep: the mesh of the scan's own grid"
done
cmp -s digest.nearest digest.mean && fail 'nearest and mean give the same mesh'

# By way of a file, and by the service: the same array.
expect 0 "$dexel" convert scan.pcd thin.pcd --size 200x130 --keep nearest
grep -aq '^WIDTH 200$' thin.pcd || fail 'convert wrote another width'
expect 0 "$dexel" mesh scan.pcd --size 200x130 --keep nearest -o mesh.ply
cat >thin.yaml <<Y
socket: $run/mesh.sock
control_socket: $run/control.sock
streams:
  - name: thin
    file: {path: scan.pcd, rate: max, lossless: yes, wait: 1, size: 200x130, keep: nearest}
Y
start_dexeld -c thin.yaml || exit 1
expect 0 "$dexel" cat --socket mesh.sock --lossless -o cat.ply
cmp mesh.ply cat.ply || fail 'the service gives another mesh'
expect 0 "$dexel" render scan.pcd --array 200x130 -o thin.png
[ -s thin.png ] || fail 'no picture'

expect 2 "$dexel" mesh scan.pcd --size 200 --stats
says 'dexel mesh: --size: '
expect 2 "$dexel" mesh scan.pcd --keep nearest --stats
says "dexel mesh: --keep: found 'nearest' without --size, expected both"
expect 2 "$dexel" convert scan.pcd x.pcd --size 20x10 --keep best
says "dexel convert: --keep: found 'best', expected centre|nearest|median|mean|first"
expect 2 "$dexel" render mesh.ply --array 20x10 -o x.png
says "dexel render: --array: found the mesh 'mesh.ply', expected a scan"
expect 1 "$dexel" mesh scan.pcd --size 2x10 --stats
says 'scan.pcd: thinning 600x400 points to 2x10 dexels'

# A twentieth of the paper's samples: still more than one for each dexel of the smaller array.
expect 0 "$dexel" bench paper --samples 320000 --rounds 1 --json
grep -q '"samples": 320000' out || fail 'bench paper without its samples'
grep -q '"two_v_minus_t": ' out || fail 'bench paper without 2V-T'
[ "$(grep -o '"paper_points_[a-z]*_ms": [0-9.]*' out | awk '$2 > 0' | wc -l)" = 4 ] ||
  fail "bench paper without the times of the paper's points"
expect 0 "$dexel" bench paper --samples 20000 --rounds 1
grep -q '^points kept ' out || fail 'bench paper without its table'
grep -q "^the paper's 883577 points at this speed: " out || fail "bench paper without the paper's points"
expect 2 "$dexel" bench paper more
says "dexel bench paper: found 'more', expected options alone"
exit $bad
