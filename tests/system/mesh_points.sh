#!/bin/sh
# Unorganized points through dexel mesh --mode project: the formats give one mesh, threads do not matter, the mesh's own
# vertices give it again, wrong use and bad files are refused with words. Real clouds where there are any.
set -u
. "$(dirname "$0")/../expect.sh"
project() { expect 0 "$dexel" mesh --mode project "$@" --stats; }

# A sphere of 2000 points, in thousandths so that text and float agree in every reader.
awk 'BEGIN {for (k = 0; k < 2000; k++) {z = 1 - (2 * k + 1) / 2000; r = sqrt(1 - z * z); a = 2.399963229728653 * k
  printf "%d %d %d\n", 8192 * r * cos(a), 8192 * r * sin(a), 8192 * z}}' >sphere.xyz
{ echo 2000; sed 's/$/ 100 1 2 3/' sphere.xyz; } >sphere.pts
sed 's/^/v /' sphere.xyz >sphere.obj
gzip -c sphere.xyz >sphere.xyz.gz
{ printf 'ply\nformat ascii 1.0\nelement vertex 2000\nproperty int x\nproperty int y\nproperty int z\nend_header\n'
  cat sphere.xyz; } >sphere.ply
{ printf 'VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE I I I\nCOUNT 1 1 1\nWIDTH 2000\nHEIGHT 1\n'
  printf 'VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2000\nDATA ascii\n'; cat sphere.xyz; } >sphere.pcd

project sphere.xyz -o mesh.ply
own=$(digest)
[ "$(number points) $(number triangles) $(number boundary_edges)" = "2000 3996 0" ] ||
  fail "a mesh of $(number points) points, $(number triangles) triangles, $(number boundary_edges) boundary edges"
says 'sphere.xyz: 2000 points; spacing'
for f in sphere.pts sphere.obj sphere.xyz.gz sphere.ply sphere.pcd mesh.ply; do
  project $f
  [ "$(digest)" = "$own" ] || fail "$f gives another mesh"
done
for n in 1 2 3 8; do
  project sphere.xyz --threads $n
  [ "$(digest)" = "$own" ] || fail "another mesh on $n threads"
done
expect 0 "$dexel" mesh sphere.xyz --mode=project -o mesh.stl
for o in '--choice next' '--choice beta --beta 15' '--plane faces' '--plane axis' '--mu 3 --alpha 150 --loops 0' \
  '--seed 5 --viewpoint 0,0,20000'; do
  # shellcheck disable=SC2086 # lists of words
  project sphere.xyz $o
  [ "$(number triangles) $(number boundary_edges)" = "3996 0" ] || fail "$o: $(number triangles) triangles"
done

# Noise as large as the spacing: holes, but a manifold whose triangles agree, by both modes that pass through the points.
expect 0 "$dexel" sim --surface random-bumpy -o noisy.ply --points 20000 --noise 1
for mode in project delaunay; do
  expect 0 "$dexel" mesh --mode $mode noisy.ply -o noisy-mesh.ply --stats
  [ "$(number split_vertices)" -gt 0 ] || fail "$mode: no fans met, so nothing is tested"
  expect 0 "$dexel" mesh --report noisy-mesh.ply
  says 'manifold      yes' out
  says 'orientation   consistent' out
done

# What it needs is told, and refused when there is less; how far it is stands on one line that is written again.
project sphere.xyz --memory 1 --progress
says 'sphere.xyz: needs about 0 MB'
says "$(printf '\rreading')"
awk 'BEGIN {for (k = 0; k < 20000; k++) print k % 141, int(k / 141), 0}' >flat.xyz
expect 1 "$dexel" mesh --mode project flat.xyz --memory 1 -o none.ply
says 'flat.xyz: 20000 points need about 4 MB, expected at most 1 MB (--memory)'
[ ! -e none.ply ] || fail "a mesh of what was refused"
expect 2 "$dexel" mesh --mode project flat.xyz --memory 0 --stats

# Scans as clouds: all scans of a file by their poses, a frame or all of what has frames, the same points from each.
expect 0 "$dexel" sim hall -o hall.ptx --size 60x40 --noise 0.004 --dropouts 0.05
expect 0 "$dexel" convert hall.ptx hall.mcap
expect 0 "$dexel" convert hall.ptx clouds.mcap --ros clouds
project hall.mcap
own=$(digest) n=$(number input_points)
[ "$n" -gt 2200 ] || fail "a cloud of $n points"
project clouds.mcap --topic /dexel/points
[ "$(digest)" = "$own" ] || fail "clouds in MCAP give another mesh than the recording"
awk 'NR == 10 {print "9 0 0 1"; next} {print}' hall.ptx >>hall.ptx.moved # columns of the pose, the position last
cat hall.ptx hall.ptx.moved >two.ptx
project two.ptx
[ "$(number input_points)" = $((2 * n)) ] || fail "two scans of $n points: $(number input_points) points"
expect 0 "$dexel" sim moving-box -o seq --size 40x30 --frames 3 --noise 0.002 --format pcd
project seq
own=$(digest) n=$(number input_points)
project 'seq/*.pcd' --frame 2
[ "$(digest)" = "$own" ] || fail "the last of three frames is another one than number 2"
project seq --frame all
[ $(($(number input_points) + $(number duplicates))) = $((3 * n)) ] || fail "all of three frames: $(number input_points) points"
expect 1 "$dexel" mesh --mode project seq --frame 3 --stats
says 'seq: found 3 frames, expected one of number 3'
expect 2 "$dexel" mesh --mode project hall.ptx --frame 0 --stats
expect 2 "$dexel" mesh --mode project hall.mcap --topic x --stats

# Far from the origin the vertices keep their digits: in PLY by doubles.
awk '{printf "%.2f %.1f %d\n", $1 + 500000000.25, $2 + 5000000000.5, $3}' sphere.xyz >far.xyz
project far.xyz -o far.ply
[ "$(number triangles)" = 3996 ] || fail "far away: $(number triangles) triangles"
project far.ply
[ "$(number triangles) $(number duplicates)" = "3996 0" ] || fail "far away, read again: $(number triangles) triangles"

# A picture of few colours is a smaller file.
expect 0 "$dexel" render mesh.ply -o all.png --edges --size 300x200 --view iso
expect 0 "$dexel" render mesh.ply -o few.png --edges --size 300x200 --view iso --few-colours
[ $((2 * $(wc -c <few.png))) -lt "$(wc -c <all.png)" ] || fail "few colours take $(wc -c <few.png) bytes, all $(wc -c <all.png)"

# Nothing to mesh is no error; what cannot be read is one.
: >empty.xyz
project empty.xyz
says 'no triangle'
printf '1 2 3\n4 5 6\nx y z\n' >bad.xyz
expect 1 "$dexel" mesh --mode project bad.xyz --stats
says 'bad.xyz: line 3: "x", expected x y z'
expect 1 "$dexel" mesh --mode project none.xyz --stats
expect 2 "$dexel" mesh --mode project sphere.xyz
expect 2 "$dexel" mesh --mode project sphere.xyz --stats --mu 0
says "--mu: found '0', expected distances from 1 to 100"
expect 2 "$dexel" mesh --mode project sphere.xyz --stats --viewpoint 1,2
expect 1 "$dexel" mesh --mode project sphere.xyz --stats --seed 2000
says '--seed: found 2000, expected less than 2000 points'
expect 2 "$dexel" mesh --mode project sphere.xyz --stats --sigma 1
expect 0 "$dexel" mesh --mode project --help

# Real clouds: manifold, and all but few points in the mesh.
for f in bunny.orig.m.gz cactus.pts distcap.pts; do
  [ -e "${DEXEL_DATA:-}/points/$f" ] || continue
  project "$DEXEL_DATA/points/$f"
  [ "$(number nonmanifold_edges) $(number duplicate_directed_edges)" = "0 0" ] || fail "$f: not a manifold"
  [ "$(number isolated)" -lt 20 ] || fail "$f: $(number isolated) points without a triangle"
done
exit $bad
