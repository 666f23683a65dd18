#!/bin/sh
# dexel mesh --report: the formats of one mesh give one report, which agrees with what the mesher said of it; what is wrong
# with a mesh is told; distances of the points it was made from are 0, of others theirs; wrong use and bad files are refused.
set -u
. "$(dirname "$0")/../expect.sh"
value() { sed -n 's/.*"'"$1"'": "\{0,1\}\([-+.0-9a-z]*\).*/\1/p' out; }
values() { for name; do printf '%s ' "$(value "$name")"; done; }
report() { expect 0 "$dexel" mesh --report --stats "$@"; }

# Half a sphere: open, one rim.
awk 'BEGIN {for (k = 0; k < 1000; k++) {z = 1 - (2 * k + 1) / 2000; r = sqrt(1 - z * z); a = 2.399963229728653 * k
  printf "%d %d %d\n", 8192 * r * cos(a), 8192 * r * sin(a), 8192 * z}}' >half.xyz
expect 0 "$dexel" mesh --mode project half.xyz -o half.ply --stats
names='points triangles edges boundary_edges components euler digest'
# shellcheck disable=SC2086 # a list of words
told=$(values $names)
for f in half.ascii.ply half.obj half.stl; do expect 0 "$dexel" mesh --mode project half.xyz -o $f --ascii; done
gzip -c half.obj >half.obj.gz
for f in half.ply half.ascii.ply half.obj half.obj.gz; do
  report $f --points half.xyz
  # shellcheck disable=SC2086 # a list of words
  [ "$(values $names)" = "$told" ] || fail "$f: $(values $names), expected $told"
  [ "$(values manifold oriented boundary_loops euler max rms)" = "true true 1 1 0.0 0.0 " ] ||
    fail "$f: $(values manifold oriented boundary_loops euler max rms)"
  [ "$(value longest_loop)" = "$(value boundary_edges)" ] || fail "$f: a rim of $(value longest_loop) edges"
done
report half.stl
[ "$(values triangles boundary_loops euler)" = "$(echo "$told" | cut -d' ' -f2) 1 1 " ] || fail "as STL another mesh"

# All that can be wrong: an edge of three triangles, a bow-tie, a turned triangle, two corners the same, a sharp angle.
cat >bad.obj <<EOF
v 0 0 0
v 1 0 0
v 0 1 0
v 0 -1 0
v 0 0 1
v 9 0 0.1
v 9 0 0
f 1 2 3
f 2 1 4
f 1 2 5
f 2 6 7
f 1 1 3
EOF
printf '0.25 0.25 0\n0 0 1\n0 -1 -2\nnan 0 0\n' >near.xyz
report bad.obj --points near.xyz
[ "$(values vertices degenerate triangles nonmanifold_edges nonmanifold_vertices duplicate_directed_edges)" = "7 1 4 1 1 1 " ] ||
  fail "of a bad mesh: $(cat out)"
[ "$(values manifold oriented components share_below_10_deg)" = "false false 1 0.25 " ] || fail "of a bad mesh: $(cat out)"
grep -qF '"distance": {"points": 3, "max": 2.0, "rms": 1.154' out || fail "of a bad mesh: $(cat out)"
expect 0 "$dexel" mesh --report bad.obj --points near.xyz
says 'manifold      no: 1 edges' out
says 'at most 2, rms 1.15' out
: >empty.obj
report empty.obj --points near.xyz
[ "$(values vertices triangles boundary_loops)" = "0 0 0 " ] || fail "of an empty mesh: $(cat out)"

expect 1 "$dexel" mesh --report half.xyz
says 'expected PLY, OBJ or STL'
expect 1 "$dexel" mesh --report none.ply
expect 1 "$dexel" mesh --report half.ply --points none.xyz
expect 2 "$dexel" mesh --report
expect 2 "$dexel" mesh --report half.ply --points
expect 2 "$dexel" mesh --report half.ply -o x.ply
expect 0 "$dexel" mesh --report --help
exit $bad
