#!/bin/sh
# dexel bench quality: the same figures for the same seed, the three forms, bars and exit status.
set -u
dexel=$(cd "${B:-build}/bin" && pwd)/dexel
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
cd "$dir" || exit 1
bad=0

# expect STATUS ARGUMENT...: of dexel bench quality; output in out and err
expect() {
  want=$1
  shift
  "$dexel" bench quality "$@" >out 2>err
  got=$?
  [ "$got" = "$want" ] || { echo "bench quality $*: status $got, expected $want"; cat out err; bad=1; }
}
has() { grep -q -- "$1" "$2" || { echo "no '$1' in $2:"; cat "$2"; bad=1; }; }

# what may not be is not, in any scene, and the command beside the figures repeats them
expect 0 topology walls --quick --check --seed 7
has '^repeat: dexel bench quality topology --seed 7 --quick$' out
has '^repeat: dexel bench quality walls --seed 7 --quick$' out
grep -q SHORT out && { cat out; bad=1; }
command=$(sed -n 's/^repeat: dexel bench quality \(walls .*\)/\1/p' out)
sed -n '/^repeat: dexel bench quality walls/,/^$/p' out >first
# shellcheck disable=SC2086 # words
expect 0 $command
sed -n '/^repeat:/,/^$/p' out | cmp - first || bad=1
expect 0 walls --quick --seed 8
sed -n '/^repeat:/,/^$/p' out | cmp -s - first && { echo "the seed does not count"; bad=1; }

# the same numbers as JSON and as Markdown
expect 0 noise --quick --json
for text in '"theme": "noise"' '"command": "dexel bench quality noise --seed 1 --quick"' '"scene": "moving-box"' \
  '"bars_short": 0' '"figure": "worst_percent", "at_most": 20.0, "met": true'; do
  has "$text" out
done
grep -q '"met": false' out && { cat out; bad=1; }
expect 0 bytes --quick --markdown
has '^## Bytes a dexel$' out
has '^    dexel bench quality bytes --seed 1 --quick$' out
has '^| hall 750x500, 2 mm | ' out

# a bar that is not met: pickets of half a scan's columns leave the hall's veil
expect 0 veil --quick
has SHORT out
expect 1 veil --quick --check

expect 2 nonsense
has "found 'nonsense', expected" err
expect 2 --seed x
expect 2 --fast
expect 0 --help
has 'usage: dexel bench quality' out
exit $bad
