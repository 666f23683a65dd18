#!/bin/sh
# Damaged recordings, through the tools and through the service: cut short at 50 places, and wrong in a dozen ways.
# Each gives status 1 and a message with the file and the place; a sequence goes on behind them.
set -u
. tests/daemon.sh
dexel=$B/bin/dexel
cuts=50
bad=0
wrong() { echo "wrong: $*"; bad=1; }

# refuses FILE COMMAND...: status 1, naming the file and a place in it; nothing written
refuses() {
  file=$1
  shift
  code=0
  timeout 300 "$dexel" "$@" >"$run/said" 2>&1 || code=$?
  [ $code = 1 ] || wrong "dexel $*: status $code, expected 1: $(cat "$run/said")"
  grep -qE "$file: .*(line|byte) [0-9]+" "$run/said" || wrong "dexel $*: no file or place in '$(cat "$run/said")'"
  [ ! -e "$run/out.ply" ] && [ ! -e "$run/out.ptx" ] && [ ! -e "$run/out.png" ] || { wrong "dexel $* left a file"; rm -f "$run"/out.*; }
}
refused() {
  refuses "$1" mesh "$run/$1" -o "$run/out.ply"
  refuses "$1" convert "$run/$1" "$run/out.ptx"
  refuses "$1" render "$run/$1" -o "$run/out.png"
}

simulate() { "$dexel" sim moving-box -o "$run/$1" --size 24x16 --noise 0.001 || exit 1; }
simulate a.ptx
simulate a.pcd
"$B/tests/pack_pcd" "$run/a.pcd" "$run/packed.pcd" || exit 1
gzip -nk "$run/a.ptx"
for whole in a.ptx a.ptx.gz a.pcd packed.pcd; do
  "$dexel" mesh "$run/$whole" -o "$run/good.ply" || wrong "$whole is not good"
done

# ---- cut short: the last line of a text may be cut in its last number, which nobody can see
mkdir "$run/scan"
for whole in a.ptx a.ptx.gz a.pcd packed.pcd; do
  len=$(wc -c <"$run/$whole") k=1
  while [ $k -le $cuts ]; do
    cut=cut-$k-$whole
    head -c $((len * k / (cuts + 1))) "$run/$whole" >"$run/$cut"
    refused "$cut"
    mv "$run/$cut" "$run/scan/"
    k=$((k + 1))
  done
done

# ---- wrong: edit NAME WHOLE SED-SCRIPT
edit() { sed "$3" "$run/$2" >"$run/$1"; refused "$1"; mv "$run/$1" "$run/scan/"; }
edit wrong-columns.ptx a.ptx '1s/.*/25/'
edit wrong-rows.ptx a.ptx '2s/.*/17/'
edit absurd-columns.ptx a.ptx '1s/.*/4294967297/'
edit absurd-size.ptx a.ptx '1,2s/.*/65535/'
edit negative-rows.ptx a.ptx '2s/.*/-16/'
edit text-columns.ptx a.ptx '1s/.*/many/'
edit text-point.ptx a.ptx '40s/^[^ ]*/0.1.2/'
edit nan-matrix.ptx a.ptx '7s/^[^ ]*/nan/'
edit inf-position.ptx a.ptx '3s/^[^ ]*/inf/'
edit few-numbers.ptx a.ptx '30s/ .*//'
edit many-numbers.ptx a.ptx '30s/$/ 1 2 3 4 5 6 7 8/'
edit wrong-points.pcd a.pcd 's/^POINTS.*/POINTS 385/'
edit wrong-width.pcd a.pcd 's/^WIDTH.*/WIDTH 25/'
edit absurd-width.pcd a.pcd 's/^WIDTH.*/WIDTH 99999999999999999999/'
edit absurd-size.pcd a.pcd 's/^\(WIDTH\|HEIGHT\).*/\1 65535/;s/^POINTS.*/POINTS 4294836225/'
edit negative-height.pcd a.pcd 's/^HEIGHT.*/HEIGHT -16/'
edit text-size.pcd a.pcd 's/^SIZE.*/SIZE 4 4 four 4/'
edit text-data.pcd a.pcd 's/^DATA.*/DATA something/'
edit absurd-count.pcd a.pcd 's/^COUNT.*/COUNT 1 1 1 4294967295/'
edit unorganized.pcd a.pcd 's/^WIDTH.*/WIDTH 384/;s/^HEIGHT.*/HEIGHT 1/'
n_bad=$(ls "$run/scan" | wc -l)

# ---- no returns: NaN and infinity in place of points are no error of the file, but there is nothing to mesh
for word in nan inf -inf 1e39; do
  sed "11,\$s/.*/$word $word $word 0.5/" "$run/a.ptx" >"$run/none.ptx"
  code=0
  timeout 300 "$dexel" mesh "$run/none.ptx" -o "$run/out.ply" 2>"$run/said" || code=$?
  [ $code = 1 ] && grep -q none.ptx "$run/said" || wrong "points of $word: status $code, $(cat "$run/said")"
done

# ---- all of them in one sequence, between two good frames
cp "$run/a.pcd" "$run/scan/0.pcd"
cp "$run/a.ptx" "$run/scan/zzz.ptx"
start_dexeld --replay "$run/scan" --rate max --socket "$run/mesh.sock" || exit 1
timeout 300 "$dexel" cat --socket "$run/mesh.sock" --lossless --stats --quiet >"$run/cat.json" || wrong "dexel cat: status $?"
"$dexel" status --socket "$run/mesh.sock" --json >"$run/status.json"
stop_dexeld || wrong "dexeld: status $?"
grep -q "\"frame\": $((n_bad + 1)), " "$run/cat.json" || wrong "the last frame is not the last good one: $(cat "$run/cat.json")"
grep -q "\"frames\":2,.*\"corrupt\":$n_bad}" "$run/status.json" || wrong "of $n_bad damaged frames: $(cat "$run/status.json")"
grep -q 'reader: replay: .*scan/absurd-columns.ptx: line 1' "$run/dexeld.log" || wrong "the log does not say what was damaged: $(cat "$run/dexeld.log")"

# ---- nothing but a damaged one: the stream ends, and subscribers hear why
start_dexeld --replay "$run/scan/cut-20-a.pcd" --rate max --socket "$run/mesh.sock" || exit 1
code=0
timeout 300 "$dexel" cat --socket "$run/mesh.sock" 2>"$run/said" || code=$?
[ $code = 1 ] || wrong "dexel cat of a stream without a frame: status $code, expected 1"
grep -q 'ended: .*cut-20-a.pcd: byte [0-9]' "$run/said" || wrong "no reason: $(cat "$run/said")"
stop_dexeld || wrong "dexeld: status $?"
echo "$n_bad damaged files"
exit $bad
