#!/bin/sh
# Ours beside PCL's OrganizedFastMesh on the same simulated scan (hall, 1 cm noise, 2 % drop-outs), one thread
# each, in turn within this run, because machines are shared: ready ranges -> f32 chunks (publish, codes, f32)
# against ready points -> triangles. Each figure is the median, with minimum and maximum, of ROUNDS runs of a
# program, which itself tells the median of a few frames.
set -eu
B=${B:-build}
ROUNDS=${ROUNDS:-7}
FRAMES=3
SIZES=${SIZES:-1500x1000 600x400 640x480} # columns x rows
SCAN="--noise 0.01 --dropouts 0.02"

skip() { echo "bench-peers: skipped: $1"; exit 0; }

. tests/peers/pcl.sh
build_pcl pcl_ofm
pcl=$B/peers/pcl_ofm

run=$(mktemp -d)
trap 'rm -rf "$run"' EXIT
one=
if command -v taskset >/dev/null && taskset -c 0 true 2>/dev/null; then one="taskset -c 0"; fi

number() { grep -o "\"$1\": [0-9.]*" "$2" | sed 's/.*: //'; }

one_round() { # SIZE: appends milliseconds to ours, limited and defaults; leaves the rest of the last run
  $one "$B/bin/dexel" bench --json --rounds $FRAMES --size "$1" $SCAN publish codes f32 >"$run/bench"
  number ms "$run/bench" | awk '{sum += $1} END {print sum}' >>"$run/ours"
  $one "$pcl" "$run/scan.pcd" $FRAMES >"$run/pcl"
  awk -v d="$run" '$1 != "peak_rss_mb" {print $2 >>(d "/" $1)}' "$run/pcl"
}

row() { # LABEL FILE TRIANGLES BOUNDARY RSS
  sort -n "$run/$2" | awk -v label="$1" -v t="$3" -v e="$4" -v rss="$5" -v ours="$ours" '
    {v[NR] = $1}
    END {m = v[int((NR + 1) / 2)]
         printf "%-38s %8.2f %8.2f %8.2f %10s %10s %7s %6.2f\n", label, m, v[1], v[NR], t, e, rss, m / ours}'
}

table() { # SIZE
  ours=$(sort -n "$run/ours" | awk '{v[NR] = $1} END {print v[int((NR + 1) / 2)]}')
  "$B/bin/dexel" mesh "$run/scan.pcd" --stats >"$run/stats"
  rss=$(number resident_bytes "$run/bench" | awk '{printf "%.0f", $1 / 1048576}')
  printf '\n%s x %s (rows x columns)\n%-38s %8s %8s %8s %10s %10s %7s %6s\n' "${1#*x}" "${1%x*}" '' median min \
    max triangles boundary 'RSS MB' ratio
  row "dexel, ranges -> f32 chunks, ms" ours "$(number triangles "$run/stats")" \
    "$(number boundary_edges "$run/stats")" "$rss"
  rss=$(awk '$1 == "peak_rss_mb" {print $2}' "$run/pcl")
  for way in limited defaults; do
    case $way in
      limited) label="PCL adaptive cut, edges <= 0.1 m, ms" ;;
      defaults) label="PCL right cut, 12.5 degrees, ms" ;;
    esac
    row "$label" $way $(awk -v w=$way '$1 == w {print $3, $4}' "$run/pcl") "$rss"
  done
}

load() { cut -d' ' -f1-3 /proc/loadavg; }

echo "load average $(load); $ROUNDS rounds of $FRAMES frames, one thread each${one:+ ($one)}"
for size in $SIZES; do
  rm -f "$run/ours" "$run/limited" "$run/defaults"
  "$B/bin/dexel" sim hall -o "$run/scan.pcd" --size "$size" $SCAN
  k=0
  while [ $k -lt "$ROUNDS" ]; do
    one_round "$size"
    k=$((k + 1))
  done
  table "$size"
done
cat <<'TEXT'

ratio: to the median of dexel, whose chunks go through one buffer; PCL keeps its triangles. Triangles and boundary
edges are those of the scan's file; only dexel closes the seam of the full turn. RSS: the process's peak, its input,
tables and libraries included.
TEXT
echo "load average $(load)"
