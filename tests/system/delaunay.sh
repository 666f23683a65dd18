#!/bin/sh
# dexel mesh --mode delaunay and dexel convert --normals: closed surfaces are closed, threads and the order of the input
# do not matter, parameters are found from the data and told; normals are written as other programs read them. The bunny,
# where it is, is closed but for what is no surface.
set -u
. "$(dirname "$0")/../expect.sh"
delaunay() { expect 0 "$dexel" mesh --mode delaunay "$@" --stats; }

expect 0 "$dexel" sim --surface random-bumpy -o bumpy.xyz --points 5000
delaunay bumpy.xyz -o mesh.ply
own=$(digest)
[ "$(number points) $(number triangles) $(number boundary_edges) $(number euler)" = "5000 9996 0 2" ] ||
  fail "a mesh of $(number points) points, $(number triangles) triangles, $(number boundary_edges) boundary edges"
says 'bumpy.xyz: delaunay: fit 16, near 16, flatten turn, reach circles, widest 2.5'
for stage in neighbours normals stars accept holes; do
  grep -q "\"stages\": {.*\"$stage\": [0-9]" out || fail "no time of stage $stage"
done
[ $(($(number by_all_corners) + $(number by_two_corners) + $(number by_one_corner) + $(number loop_triangles))) = 9996 ] ||
  fail "triangles of all kinds are not all triangles"
for n in 1 2 3 8; do
  delaunay bumpy.xyz --threads $n
  [ "$(digest)" = "$own" ] || fail "another mesh on $n threads"
done
for o in '--flatten shadow' '--reach paper' '--fit 24 --near 12' '--widest 4 --loops 0' '--viewpoint 0,0,9'; do
  # shellcheck disable=SC2086 # lists of words
  delaunay bumpy.xyz $o
  [ "$(number points) $(number nonmanifold_edges) $(number duplicate_directed_edges)" = "5000 0 0" ] ||
    fail "$o: $(number points) points, $(number nonmanifold_edges) edges of three triangles"
  [ "$(number boundary_edges)" -lt 30 ] || fail "$o: $(number boundary_edges) boundary edges"
done
expect 0 "$dexel" sim --surface random-bumpy -o noisy.xyz --points 5000 --noise 0.4
delaunay noisy.xyz
says 'delaunay: fit 48, near 32, flatten shadow'
[ "$(number boundary_edges)" -lt 60 ] || fail "noise leaves $(number boundary_edges) boundary edges"
expect 2 "$dexel" mesh --mode delaunay bumpy.xyz --stats --fit 2
expect 2 "$dexel" mesh --mode delaunay bumpy.xyz --stats --flatten up
expect 2 "$dexel" mesh --mode delaunay bumpy.xyz --stats --widest 0.5

# Normals: all point away from the middle of a sphere, in each form; nothing else is lost or moved.
expect 0 "$dexel" sim --surface random-sphere -o sphere.xyz --points 3000
for form in ply pcd; do
  expect 0 "$dexel" convert --normals sphere.xyz n.$form --ascii --threads 2
  says 'sphere.xyz: 3000 points; spacing'
  says 'fit 16; 1 part'
  awk 'header {if ($1 * $4 + $2 * $5 + $3 * $6 < 0.9 || NF != 7) bad++; n++}
    /^end_header|^DATA/ {header = 1}
    END {if (n != 3000 || bad) {print n, "points,", bad + 0, "with a wrong normal"; exit 1}}' n.$form ||
    fail "normals in $form"
  expect 0 "$dexel" convert --normals sphere.xyz b.$form
done
expect 0 "$dexel" convert --normals sphere.xyz n.xyz
awk '{print $1, $2, $3}' n.xyz | cmp -s - sphere.xyz || fail "points moved"
expect 0 "$dexel" convert --normals sphere.xyz in.xyz --viewpoint 0,0,0
awk '$1 * $4 + $2 * $5 + $3 * $6 > -0.9 {exit 1}' in.xyz || fail "normals do not face the viewpoint"
delaunay sphere.xyz
own=$(digest)
for f in n.ply n.pcd b.ply b.pcd; do
  delaunay $f
  [ "$(digest)" = "$own" ] || fail "$f has other points"
done
grep -qx 'FIELDS x y z normal_x normal_y normal_z curvature' n.pcd || fail "fields of PCD"
[ "$(grep -c '^property float n[xyz]$' n.ply)" = 3 ] || fail "properties of PLY"
awk '{printf "%.3f %.3f %.3f\n", $1 + 3000000, $2, $3}' sphere.xyz >far.xyz
expect 0 "$dexel" convert --normals far.xyz far.ply --ascii
[ "$(grep -c '^property double' far.ply)" = 3 ] || fail "floats of what floats do not hold"

# What is no cloud, and wrong use.
printf '1 2 3\n1 2 3\n2 3 4\nnan 0 0\n' >few.xyz
expect 0 "$dexel" convert --normals few.xyz few.pcd --ascii
says '2 points, 1 not finite, 1 duplicates'
says '2 without a normal'
[ "$(grep -c 'nan nan nan nan' few.pcd)" = 2 ] || fail "normals of two points"
delaunay few.xyz
[ "$(number triangles)" = 0 ] || fail "triangles of two points"
expect 2 "$dexel" convert --normals sphere.xyz
expect 2 "$dexel" convert --normals sphere.xyz n.stl
expect 2 "$dexel" convert --normals sphere.xyz n.ply --fit 65
expect 2 "$dexel" convert --normals sphere.xyz n.ply --frame 0
expect 1 "$dexel" convert --normals none.xyz n2.ply
[ ! -e n2.ply ] || fail "points of no file"

bunny=${DEXEL_DATA:-}/points/bunny.orig.m.gz
if [ -e "$bunny" ]; then
  delaunay "$bunny"
  [ "$(number triangles)" -ge 69600 ] && [ "$(number boundary_edges)" -le 20 ] ||
    fail "the bunny: $(number triangles) triangles, $(number boundary_edges) boundary edges"
fi
exit $bad
