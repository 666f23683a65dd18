#!/bin/sh
# Levels of detail from the service: each commit that a lossless subscriber gets is the mesh that `dexel mesh` makes
# of that frame at that level, though only the tiles come that changed; and what there is not is refused in words.
set -eu
. tests/daemon.sh
dexel=$B/bin/dexel
frames=6
wrong() { echo "$1"; exit 1; }

# a box that moves before a wall without noise: most tiles of a frame stay as they are, but not all of their borders
"$dexel" sim moving-box -o "$run/scan" --format pcd --size 320x240 --noise 0 --dropouts 0.0002 --frames $frames
level_of() { # level_of NAME: its options
  case $1 in
  sigma) echo --lod 2.5 ;;
  stride) echo --stride 8 ;;
  both) echo --lod 4 --stride 16 ;;
  esac
}
for level in sigma stride both; do
  n=0
  while [ $n -lt $frames ]; do
    # shellcheck disable=SC2046 # words
    "$dexel" mesh "$run/scan" --frame $n $(level_of $level) -o "$run/mesh-$level-$(printf %06d $n).ply"
    n=$((n + 1))
  done
done

start_dexeld --replay "$run/scan" --rate max --wait 4 --socket "$run/mesh.sock"
pids=
for level in sigma stride both; do
  # shellcheck disable=SC2046 # words
  "$dexel" cat --socket "$run/mesh.sock" --lossless $(level_of $level) -o "$run/$level-%06d.ply" --every --stats --quiet >"$run/$level.json" &
  pids="$pids $!"
done
"$dexel" cat --socket "$run/mesh.sock" --lossless --stats --quiet >"$run/whole.json"
for pid in $pids; do wait "$pid"; done
"$dexel" status --socket "$run/mesh.sock" --json >"$run/status"
stop_dexeld

bytes() { sed -n 's/.*"bytes": \([0-9]*\).*/\1/p' "$run/$1.json"; }
for level in sigma stride both; do
  grep -q "\"commits\": $frames, \"frame\": $((frames - 1)), \"frames_missed\": 0," "$run/$level.json" || wrong "$level: $(cat "$run/$level.json")"
  grep -q '"nonmanifold_edges": 0, "duplicate_directed_edges": 0' "$run/$level.json" || wrong "$level: $(cat "$run/$level.json")"
  for mesh in "$run"/mesh-$level-*.ply; do cmp "$mesh" "$run/$level-${mesh##*-}"; done
  [ $((2 * $(bytes $level))) -lt "$(bytes whole)" ] || wrong "$level: $(bytes $level) bytes, the whole mesh $(bytes whole)"
done

# Samples that are left out lie near the triangle that their beams meet, at creases too: middles are within the bound, and
# departures add up over the levels.
"$dexel" sim hall -o "$run/hall.pcd" --size 320x240
for bound in 0.25 1; do
  "$dexel" mesh "$run/hall.pcd" --stats --lod $bound >"$run/stats"
  awk -F'"max_sigma": ' -v bound=$bound 'NF > 1 {seen = 1; if ($2 + 0 > 3 * bound) exit 1} END {exit !seen}' "$run/stats" ||
    wrong "$bound sigma: $(cat "$run/stats")"
done

# what there is not
refused() { # refused TEXT OPTION...
  text=$1
  shift
  code=0
  timeout 300 "$dexel" "$@" >"$run/out" 2>"$run/err" || code=$?
  [ $code != 0 ] || wrong "$*: taken"
  grep -q -- "$text" "$run/err" || wrong "$*: $(cat "$run/err")"
}
refused "--lod: found '0', expected" mesh "$run/scan" --stats --lod 0
refused "--stride: found '3', expected" mesh "$run/scan" --stats --stride 3
refused "with a level of detail, expected f32" mesh "$run/scan" --stats --lod 4 --encoding q16
refused "with a level of detail, expected f32" cat --socket "$run/mesh.sock" --lod 4 --encoding delta
