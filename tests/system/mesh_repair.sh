#!/bin/sh
# dexel mesh --repair: meshes with known damages come out without them, as the report of what was written tells; meshes
# that are whole stay as they are; the same after a mode; wrong use and bad files are refused.
set -u
. "$(dirname "$0")/../expect.sh"
value() { sed -n 's/.*"'"$1"'": "\{0,1\}\([-+.0-9a-z]*\).*/\1/p' out; }
values() { for name; do printf '%s ' "$(value "$name")"; done; }
repair() { expect 0 "$dexel" mesh --repair "$@" --stats; }
sound() { # FILE: a manifold whose triangles agree
  expect 0 "$dexel" mesh --report "$1" --stats
  [ "$(values degenerate manifold oriented)" = "0 true true " ] || fail "$1: $(cat out)"
}

# An edge of three triangles, a bow-tie, a turned triangle, two corners the same, one triangle twice.
cat >bad.obj <<EOT
v 0 0 0
v 1 0 0
v 0 1 0
v 0 -1 0
v 0 0 1
v 9 0 0.1
v 9 0 0
v 2 1 0
f 1 2 3
f 2 1 4
f 1 2 5
f 2 6 7
f 1 1 3
f 2 3 1
f 3 2 8
f 2 3 8
EOT
repair bad.obj -o good.ply
[ "$(values degenerate duplicate nonmanifold turned split removed holes triangles)" = "1 2 1 0 3 0 0 5 " ] ||
  fail "of a bad mesh: $(cat out)"
says 'bad.obj: repair: 1 triangles of two equal corners left out, 2 triangles left out that were there already'
sound good.ply
[ "$(values triangles points)" = "5 11 " ] || fail "what is written: $(cat out)"
sed 's/^f 3 2 8/f 3 8 2/' bad.obj >turned.obj
repair turned.obj -o turned.ply
[ "$(value turned)" = 1 ] || fail "a triangle turned: $(cat out)"
sound turned.ply

# A sphere with a hole of one vertex, and with half of itself missing; whole, it stays as it is.
awk 'BEGIN {for (k = 0; k < 2000; k++) {z = 1 - (2 * k + 1) / 2000; r = sqrt(1 - z * z); a = 2.399963229728653 * k
  printf "%d %d %d\n", 8192 * r * cos(a), 8192 * r * sin(a), 8192 * z}}' >sphere.xyz
expect 0 "$dexel" mesh --mode project sphere.xyz -o sphere.obj --stats
own=$(digest)
repair sphere.obj -o same.ply
[ "$(digest)" = "$own" ] || fail "a whole mesh became another one"
says 'sphere.obj: repair: nothing to mend'
awk '$1 != "f" || ($2 != 700 && $3 != 700 && $4 != 700)' sphere.obj >hole.obj
repair hole.obj -o closed.ply
[ "$(values holes boundary_edges euler)" = "1 0 2 " ] || fail "a hole: $(cat out)"
sound closed.ply
repair hole.obj --repair-holes 3
[ "$(values holes)" = "0 " ] || fail "a hole of more than 3 edges: $(cat out)"
awk '$1 != "f" || NR % 13' sphere.obj >ragged.obj
repair ragged.obj -o ragged.ply --ascii
[ "$(value boundary_edges)" = 0 ] || fail "many holes: $(cat out)"
sound ragged.ply

# After a mode; of a scan too.
expect 0 "$dexel" mesh --mode project sphere.xyz --alpha 60 --loops 0 -o open.ply --stats
[ "$(value boundary_edges)" -gt 0 ] || fail "expected an open mesh"
expect 0 "$dexel" mesh --mode project sphere.xyz --alpha 60 --loops 0 -o after.ply --repair --stats
[ "$(value holes)" -gt 0 ] || fail "repair after a mode: $(cat out)"
sound after.ply
expect 0 "$dexel" sim hall -o hall.ptx --size 60x40 --noise 0.004 --dropouts 0.05
expect 0 "$dexel" mesh --mode terrain hall.ptx -o hall.ply --repair --repair-holes 8 --stats
[ "$(value holes)" -gt 0 ] || fail "repair of a scan's mesh: $(cat out)"
sound hall.ply

: >empty.obj
repair empty.obj
[ "$(value triangles)" = 0 ] || fail "of an empty mesh: $(cat out)"
expect 1 "$dexel" mesh --repair sphere.xyz --stats
expect 1 "$dexel" mesh --repair none.ply --stats
expect 2 "$dexel" mesh --repair bad.obj
expect 2 "$dexel" mesh --repair bad.obj -o x.txt
expect 2 "$dexel" mesh --repair bad.obj --stats --repair-holes 65
says "--repair-holes: found '65', expected edges from 0 to 64"
expect 0 "$dexel" mesh --repair --help
exit $bad
