#!/bin/sh
# Noisy points through dexel mesh --mode smooth and dexel convert --smooth: a closed mesh near the truth, each stage on its
# own, the same bytes for any number of threads, normals that face away, odd and bad input.
set -u
. "$(dirname "$0")/../expect.sh"
in_file() { grep -a '^element vertex' "$1" | cut -d' ' -f3; }
smooth() { expect 0 "$dexel" mesh --mode smooth "$@" --stats; }

expect 0 "$dexel" sim --surface random-bumpy -o noisy.ply --points 12000 --noise 0.4
expect 0 "$dexel" sim --surface random-bumpy -o truth.ply --points 40000
smooth noisy.ply -o mesh.ply
own=$(digest)
[ "$(number boundary_edges) $(number euler)" = "0 2" ] || fail "$(number boundary_edges) boundary edges, euler $(number euler)"
[ "$(number triangles)" -gt "$(number grown_triangles)" ] || fail "nothing was refined"
says 'noisy.ply: smooth: spacing'
says 'clusters of 8 to 32 points'
for n in 1 2 3 8; do
  smooth noisy.ply --threads $n
  [ "$(digest)" = "$own" ] || fail "another mesh on $n threads"
done
expect 0 "$dexel" mesh --report mesh.ply --points truth.ply
says "manifold      yes" out
says "orientation   consistent" out
awk '/distance/ {exit !($NF < 0.008)}' out || fail "far from the truth: $(grep distance out)"

# Stages on their own: points with normals, fewer points, a mesh of points without noise, one that is not refined.
smooth noisy.ply --stages smooth --ascii -o points.ply
[ "$(in_file points.ply) $(number triangles)" = "12000 0" ] || fail "smoothed: $(in_file points.ply) points"
smooth noisy.ply --stages smooth,cluster,reduce -o few.ply
[ "$(in_file few.ply)" = "$(number representatives)" ] || fail "reduced: $(in_file few.ply) points"
smooth few.ply --stages grow
grown=$(digest)
smooth noisy.ply --refine 0
[ "$(digest)" = "$grown" ] || fail "a mesh of the reduced points is another one"
[ "$(number triangles)" = "$(number grown_triangles)" ] || fail "refined without being asked"
for o in '--fit quadric' '--passes 2 --sw 1.5 --sr 2.5' '--max-points 64 --tolerance 0.05' '--loops 30 --ratio 4 --bend 90'; do
  # shellcheck disable=SC2086 # lists of words
  smooth noisy.ply $o
  [ "$(number euler)" = 2 ] || fail "$o: euler $(number euler)"
done
smooth noisy.ply --split v1 --max-points 0
smooth truth.ply --stages cluster
for list in smooth,foo '' reduce refine cluster,refine; do
  expect 1 "$dexel" mesh --mode smooth noisy.ply --stages "$list" --stats
  says 'expected'
done
expect 2 "$dexel" mesh --mode smooth noisy.ply --sw 9 --stats

# convert --smooth: the same points, text or PLY; normals of a closed surface face away from its middle.
expect 0 "$dexel" convert --smooth noisy.ply smooth.xyz
[ "$(wc -l <smooth.xyz)" = 12000 ] || fail "not all points are there"
awk '{if ($1 * $4 + $2 * $5 + $3 * $6 < 0) bad++; d = $4^2 + $5^2 + $6^2; if (d < 0.999 || d > 1.001) odd++}
  END {exit bad + odd > 12}' smooth.xyz || fail "normals to both sides, or of no unit length"
expect 0 "$dexel" convert --smooth noisy.ply smooth.ply --ascii
numbers() { sed '1,/end_header/d' "$1" | cut -d' ' -f 1-6; }
numbers smooth.ply >convert.txt
numbers points.ply >mesh.txt
# a mesh's vertices are floats
paste convert.txt mesh.txt | awk '{for (k = 1; k <= 6; k++) {d = $k - $(k + 6); if (d > 1e-6 || d < -1e-6) bad++}}
  END {exit bad > 0 || NR != 12000}' || fail "convert and mesh do not smooth alike"
expect 0 "$dexel" convert --smooth noisy.ply smooth.pcd
grep -aq '^FIELDS x y z normal_x normal_y normal_z curvature' smooth.pcd || fail "smooth.pcd has no normals"
expect 0 "$dexel" convert --smooth noisy.ply -o thin.xyz --thin 20 --fit quadric --passes 2
[ "$(wc -l <thin.xyz)" -lt 1800 ] || fail "nothing was thinned"
expect 2 "$dexel" convert --smooth noisy.ply smooth.foo
expect 2 "$dexel" convert --smooth noisy.ply
expect 1 "$dexel" convert --smooth missing.ply smooth.ply

# Odd input: a clear result.
: >empty.xyz
printf '1 2 3\n' >one.xyz
printf '1 2 3\n1 2 3\n1 2 3\n' >same.xyz
awk 'BEGIN {for (k = 0; k < 100; k++) print k, 2 * k, 3 * k}' >line.xyz
awk 'BEGIN {for (k = 0; k < 400; k++) print k % 20, int(k / 20), 5}' >grid.xyz
awk 'BEGIN {for (k = 0; k < 400; k++) print 1e12 + k % 20, int(k / 20), (k == 9 ? "nan" : 5)}' >far.xyz
for f in empty one same line; do
  expect 0 "$dexel" mesh --mode smooth $f.xyz -o $f.ply
  says 'no triangle'
  expect 0 "$dexel" convert --smooth $f.xyz $f.ply
done
smooth grid.xyz --stages smooth,grow
[ "$(number triangles) $(number boundary_edges)" = "722 76" ] || fail "a grid: $(number triangles) triangles"
smooth far.xyz
[ "$(number not_finite)" = 1 ] || fail "$(number not_finite) points that are not finite"
exit $bad
