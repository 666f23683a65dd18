#!/bin/sh
# dexel sim --surface: every surface of the list gives a cloud, the same as PLY and as text and for the same seed; the closed
# ones mesh to a manifold of their Euler characteristic; wrong use is refused and leaves nothing.
set -u
. "$(dirname "$0")/../expect.sh"
value() { sed -n 's/.*"'"$1"'": "\{0,1\}\([-+.0-9a-z]*\).*/\1/p' out; }
mesh() { expect 0 "$dexel" mesh --mode project "$@" --stats; }

expect 0 "$dexel" sim --surface --list
cp out list
[ "$(wc -l <list)" -ge 12 ] || fail "few surfaces: $(cat list)"
while read -r name _ _ euler _ rims; do
  euler=${euler%,}
  expect 0 "$dexel" sim --surface "$name" -o a.ply --points 6000
  expect 0 "$dexel" sim --surface "$name" -o a.xyz --points 6000
  mesh a.ply -o mesh.ply
  own=$(value digest)
  mesh a.xyz
  [ "$(value digest)" = "$own" ] || fail "$name: text gives another mesh"
  case $name in random-*) continue ;; esac
  expect 0 "$dexel" mesh --report mesh.ply --stats
  [ "$(value manifold) $(value euler) $(value boundary_loops)" = "true $euler $rims" ] ||
    fail "$name: manifold $(value manifold), Euler characteristic $(value euler), $(value boundary_loops) rims"
done <list

expect 0 "$dexel" sim --surface bumpy -o a.ply
for o in '--seed 1' '--seed 1 --jitter 0.3' '--seed 2 --jitter 0.3' '--seed 2 --noise 0.3' '--points 9000'; do
  # shellcheck disable=SC2086 # lists of words
  expect 0 "$dexel" sim --surface bumpy -o b.ply $o
  cmp -s a.ply b.ply
  same=$?
  case $o in '--seed 1') want=0 ;; *) want=1 ;; esac
  [ $same = $want ] || fail "$o: cmp gives $same"
  cp b.ply a.ply
done
expect 0 "$dexel" sim --surface nested -o a.ply --gap 8
expect 0 "$dexel" sim --surface nested -o b.ply
cmp -s a.ply b.ply && fail "the gap does not count"

touch before after
ls -A >before
expect 2 "$dexel" sim --surface; says 'a surface'
expect 2 "$dexel" sim --surface hall -o x.ply; says "'hall'"
expect 2 "$dexel" sim --surface bumpy; says '.ply or .xyz'
expect 2 "$dexel" sim --surface bumpy -o x.pcd; says '.ply or .xyz'
expect 2 "$dexel" sim --surface bumpy -o x.ply --points 63; says '63'
expect 2 "$dexel" sim --surface bumpy -o x.ply --noise -1; says '--noise'
expect 2 "$dexel" sim --surface nested -o x.ply --gap 900; says '--gap'
expect 2 "$dexel" sim --surface bumpy -o x.ply --frames 2
expect 1 "$dexel" sim --surface bumpy -o none/x.ply; says 'none/x.ply'
expect 0 "$dexel" sim --surface --help
ls -A >after
cmp before after || bad=1
exit $bad
