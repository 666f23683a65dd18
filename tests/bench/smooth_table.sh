#!/bin/sh
# Table 1 of Mederos, Velho and de Figueiredo (2004) in shape, in Markdown: stages of dexel mesh --mode smooth, one thread, on
# noisy stand-ins of the paper's numbers of points. Seconds are of the processor, the least of ROUNDS runs; the
# paper's are of a 1.8 GHz Pentium 4. The truth is sampled without noise; its distance to the mesh is told in spacings.
#   smooth_table.sh      ROUNDS=N (3)  NOISE=N (0.4 spacings)
set -eu
B=${B:-build}
ROUNDS=${ROUNDS:-3}
NOISE=${NOISE:-0.4}
run=$(mktemp -d)
trap 'rm -rf "$run"' EXIT
dexel=$B/bin/dexel

value() { sed -n 's/.*"'"$1"'": \([-+.0-9a-z]*\).*/\1/p' "$2"; }
least() { # STAGE
  for f in "$run"/stats.*; do
    sed -n 's/.*"processor_seconds": {[^}]*"'"$1"'": \([-+.0-9a-z]*\).*/\1/p' "$f"
  done | sort -g | head -n 1
}

row() { # MODEL POINTS SURFACE PAPER_SECONDS OPTIONS...
  model=$1 n=$2 surface=$3 paper=$4
  shift 4
  "$dexel" sim --surface "$surface" -o "$run/points.ply" --points "$n" --noise "$NOISE"
  "$dexel" sim --surface "$surface" -o "$run/truth.ply" --points 200000
  rm -f "$run"/stats.*
  k=0
  while [ $k -lt "$ROUNDS" ]; do
    "$dexel" mesh --mode smooth "$run/points.ply" -o "$run/mesh.ply" --threads 1 --stats "$@" >"$run/stats.$k" 2>"$run/log"
    k=$((k + 1))
  done
  "$dexel" mesh --report "$run/mesh.ply" --points "$run/truth.ply" --stats >"$run/report"
  s=$(least smooth) s2=$(least smooth2)
  side=$(value side "$run/stats.0")
  awk -v model="$model" -v n="$(value input_points "$run/stats.0")" -v surface="$surface" -v paper="$paper" -v s="$s" \
    -v s2="${s2:-0}" -v c="$(least cluster)" -v r="$(least reduce)" -v g="$(least grow)" -v r1="$(least refine)" \
    -v r2="$(least refine2)" -v reps="$(value representatives "$run/stats.0")" -v t="$(value grown_triangles "$run/stats.0")" \
    -v t1="$(value refine_triangles "$run/stats.0")" -v t2="$(value refine2_triangles "$run/stats.0")" \
    -v b="$(value boundary_edges "$run/report")" -v e="$(value nonmanifold_edges "$run/report")" \
    -v d="$(sed -n 's/.*"rms": \([0-9.e+-]*\).*/\1/p' "$run/report")" -v side="$side" 'BEGIN {
    sum = s + s2 + c + r + g + r1 + r2
    printf "| %s: %s | %d | %.2f (%s) | %.3f, %d p | %.3f, %d t | %.3f, %d t | %.3f, %d t | %.2f | %d, %d | %.3f |\n", model,
      surface, n, s + s2, paper, c + r, reps, g, t, r1, t1, r2, t2, 1e6 * sum / n, b, e, d / side}'
}

cat <<'TEXT'
| model: stand-in | points | S, s (paper) | C, s | T, s | R1, s | R2, s | µs/point | boundary, edges+ | rms |
|---|---|---|---|---|---|---|---|---|---|
TEXT
row Dino 56194 random-bumpy 163.21
row Dog 195586 random-bumpy 1004.96
row Igea 134359 random-sphere 407.94
row Dragon 100056 double-torus 292.94
row Knot 71255 random-torus "407.71, two passes" --passes 2
