#!/bin/sh
# dexel sim and dexel convert: what they write, their exit status, and that nothing is left behind.
set -u
dexel=$(cd "${B:-build}/bin" && pwd)/dexel
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
cd "$dir" || exit 1
bad=0

# expect STATUS COMMAND...: its exit status; output in out and err
expect() {
  want=$1
  shift
  "$@" >out 2>err
  got=$?
  [ "$got" = "$want" ] || { echo "$*: status $got, expected $want"; cat err; bad=1; }
}
says() { grep -q -- "$1" err || { echo "expected '$1', found: $(cat err)"; bad=1; }; }
same() { cmp "$1" "$2" || bad=1; }

# every scene of --list, and through each format and back the same points to the last digit but one
expect 0 "$dexel" sim --list
scenes=$(cut -d' ' -f1 out)
[ "$(echo "$scenes" | wc -l)" -ge 8 ] || { echo "few scenes: $scenes"; bad=1; }
for scene in $scenes; do
  expect 0 "$dexel" sim "$scene" -o "$scene.ptx" --size 120x80 --noise 0.002,0,0.0001 --dropouts 0.01 --mixed 0.5 --seed 7 --attr 16
  expect 0 "$dexel" sim "$scene" -o "$scene.pcd" --size 120x80 --noise 0.002,0,0.0001 --dropouts 0.01 --mixed 0.5 --seed 7 --attr 16
  expect 0 "$dexel" convert "$scene.pcd" one.ptx --unit 0.001
  expect 0 "$dexel" convert "$scene.ptx" two.ptx --unit 0.001
  expect 0 "$dexel" convert two.ptx three.pcd --unit 0.001
  [ "$(wc -l <"$scene.ptx")" = "$(wc -l <one.ptx)" ] || { echo "$scene: lines differ"; bad=1; }
  [ "$(grep -c '^0 0 0 ' "$scene.ptx")" = "$(grep -c '^0 0 0 ' one.ptx)" ] || { echo "$scene: holes differ"; bad=1; }
done

# the same seed, the same bytes; another seed, others
expect 0 "$dexel" sim hall -o a.ptx --size 60x40 --noise 0.01 --seed 3
expect 0 "$dexel" sim hall -o b.ptx --size 60x40 --noise 0.01 --seed 3
same a.ptx b.ptx
expect 0 "$dexel" sim hall -o b.ptx --size 60x40 --noise 0.01 --seed 4
cmp -s a.ptx b.ptx && { echo "the seed does not count"; bad=1; }

# sequences: a directory of files, one PTX of several scans, and back
expect 0 "$dexel" sim moving-box -o seq --size 64x48 --frames 3 --format pcd
[ "$(ls seq | tr '\n' ' ')" = "frame-000000.pcd frame-000001.pcd frame-000002.pcd " ] || { echo "seq holds $(ls seq)"; bad=1; }
expect 0 "$dexel" convert seq all.ptx --unit 0.001
[ "$(grep -c '^64$' all.ptx)" = 3 ] || { echo "all.ptx does not hold 3 scans"; bad=1; }
expect 0 "$dexel" convert all.ptx back --unit 0.001 --format pcd
[ "$(ls back | wc -l)" = 3 ] || { echo "back holds $(ls back)"; bad=1; }

mkdir run.7 plain
for folder in run.7 plain run.7/more/ .; do
  expect 0 "$dexel" convert a.ptx "$folder" --unit 0.001
  [ -s "$folder/frame-000000.ptx" ] || { echo "$folder: no frame in it"; bad=1; }
done
rm frame-000000.ptx

# what is wrong is told, with the right status, and leaves nothing
touch before after
ls -A >before
expect 2 "$dexel" sim; says 'a scene'
expect 2 "$dexel" sim nowhere -o x.ptx; says "'nowhere'"
expect 2 "$dexel" sim hall; says '-o'
expect 2 "$dexel" sim hall -o x.ptx --size 7x1; says '7x1'
expect 2 "$dexel" sim hall -o x.ptx --noise much; says "'much'"
expect 2 "$dexel" sim hall -o x.ptx --dropouts 2; says "'2'"
expect 2 "$dexel" sim hall -o x.ptx --attr 12; says '0|8|16'
expect 2 "$dexel" sim hall -o x.ptx --nothing
# a directory is not made of a name that must be meant as a file
for name in x.pcd.gz x.ptx.gz x.gz x.ply x.pcd/ ./seq/x.xyz .x; do
  expect 2 "$dexel" sim hall -o "$name" --size 60x40; says "found '$name', expected a name ending in .ptx or .pcd"
  expect 2 "$dexel" convert a.ptx "$name"; says "found '$name', expected a name ending in .ptx or .pcd"
done
expect 1 "$dexel" sim hall -o none/x.ptx --size 60x40; says 'none/x.ptx'
expect 1 "$dexel" sim moving-box -o x.pcd --size 64x48 --frames 2; says 'x.pcd'
expect 2 "$dexel" convert a.ptx; says 'IN and OUT'
expect 1 "$dexel" convert none.ptx x.ptx; says 'none.ptx'
expect 1 "$dexel" convert all.ptx x.pcd; says 'x.pcd'
head -c 3000 a.ptx >cut.ptx
expect 1 "$dexel" convert cut.ptx x.ptx; says 'cut.ptx'
rm cut.ptx
ls -A >after
same before after
expect 0 "$dexel" sim --help
expect 0 "$dexel" convert --help
exit $bad
