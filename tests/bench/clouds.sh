#!/bin/sh
# Unorganized points by projection, in numbers: table 1 of Gopi and Krishnan (2002) on stand-ins of as many points, and
# how time and memory grow with the points. Seconds are what the processor worked, so that others on the machine disturb
# them less; the least of ROUNDS processes on one processor. Real clouds come
# after the stand-ins when $DEXEL_DATA has them.
#   clouds.sh [--markdown]    ROUNDS=N  LARGE=1: to ten million points, which takes minutes
set -eu
B=${B:-build}
ROUNDS=${ROUNDS:-3}
SIZES=${SIZES:-10000 30000 100000 300000 1000000}
[ -z "${LARGE:-}" ] || SIZES="$SIZES 3000000 10000000"
dexel=$B/bin/dexel
markdown=
[ "${1:-}" != --markdown ] || markdown=1
run=$(mktemp -d)
trap 'rm -rf "$run"' EXIT
one=
if command -v taskset >/dev/null && taskset -c 0 true 2>/dev/null; then one="taskset -c 0"; fi

value() { sed -n 's/.*"'"$1"'": \([-+.0-9a-z]*\).*/\1/p' "$run/stats"; }
load() { cut -d' ' -f1-3 /proc/loadavg; }

# cells CELL...: a line of the table
cells() {
  if [ "$markdown" ]; then
    printf '|'
    for cell; do printf ' %s |' "$cell"; done
  else
    for cell; do printf '%-13s' "$cell"; done
  fi
  printf '\n'
}

columns() {
  cells "$@"
  [ "$markdown" ] || return 0
  printf '|---|'
  shift
  for cell; do printf -- '---:|'; done
  printf '\n'
}

# measure FILE OPTIONS...: what is read and sorted to $init, what is meshed to $mesh, seconds, the least of all rounds
measure() {
  : >"$run/times"
  k=0
  while [ $k -lt "$ROUNDS" ]; do
    $one "$dexel" mesh --mode project "$@" --threads 1 --stats >"$run/stats" 2>"$run/log"
    echo "$(value read_cpu_seconds) $(value load_cpu_seconds) $(value mesh_cpu_seconds)" >>"$run/times"
    k=$((k + 1))
  done
  init=$(awk '{print $1 + $2}' "$run/times" | sort -n | head -n 1)
  mesh=$(awk '{print $3}' "$run/times" | sort -n | head -n 1)
  points=$(value input_points)
  triangles=$(value triangles)
  boundary=$(value boundary_edges)
}

# model NAME FILE TRIANGLES INIT RECONSTRUCTION: the last three of the paper, or -
model() {
  measure "$2"
  full="$points $triangles $((2 * points - triangles)) $boundary $(printf '%.4f %.4f' "$init" "$mesh")"
  speed=$(awk -v m="$mesh" -v p="$5" 'BEGIN {if (p + 0) printf "%.0f", p / m; else print "-"}')
  measure "$2" --plane axis
  [ "$3" = - ] && left=- || left=$((2 * $6 - $3))
  # shellcheck disable=SC2086 # words
  cells "$1" $full "$3" "$left" "$4" "$5" "$speed" "$((2 * points - triangles))" "$(printf '%.4f' "$mesh")"
}

stand_in() { # NAME POINTS TRIANGLES INIT RECONSTRUCTION
  "$dexel" sim --surface bumpy --jitter 0.3 --points "$2" -o "$run/$1.ply"
  model "$1" "$run/$1.ply" "$3" "$4" "$5" "$2"
}

table_of_the_paper() {
  columns model points triangles 2V-T boundary 'init, s' 'mesh, s' "paper's T" 2V-T 'init, s' 'rec., s' times 'axis: 2V-T' 'mesh, s'
  stand_in Mannequin 12772 25349 0.2405 3.9289
  stand_in Club 16864 33660 0.2758 3.9644
  stand_in Foot 20021 39919 0.3802 5.2725
  stand_in Bunny 34834 69497 0.5961 9.1809
  stand_in Skidoo 37974 75461 0.6680 8.536
  stand_in Phone 83034 165730 1.5634 26.597
  for f in bunny.orig.m.gz cactus.pts distcap.pts; do
    [ -e "${DEXEL_DATA:-}/points/$f" ] || continue
    case $f in
    bunny*) model "$f" "$DEXEL_DATA/points/$f" 69497 0.5961 9.1809 34834 ;;
    *) model "$f" "$DEXEL_DATA/points/$f" - - - ;;
    esac
  done
}

growth() {
  "$dexel" sim --surface bumpy --points 64 -o "$run/cloud.ply"
  measure "$run/cloud.ply"
  program=$(value peak_rss_bytes)
  columns points 'init, s' 'mesh, s' 'us/point' 'peak, MB' 'B/point'
  : >"$run/growth"
  for n in $SIZES; do
    "$dexel" sim --surface bumpy --jitter 0.3 --points "$n" -o "$run/cloud.ply"
    measure "$run/cloud.ply"
    echo "$points $mesh" >>"$run/growth"
    # shellcheck disable=SC2046 # words
    cells "$points" $(awk -v n="$points" -v i="$init" -v m="$mesh" -v b="$(value peak_rss_bytes)" -v p="$program" 'BEGIN {
      printf "%.4f %.4f %.2f %.1f %.0f", i, m, 1e6 * m / n, b / 1e6, (b - p) / n}')
  done
  awk '{x = log($1); y = log($2); n++; sx += x; sy += y; sxx += x * x; sxy += x * y}
    END {if (n > 1) printf "\nTime of meshing grows as points to the power %.3f (least squares of the logarithms).\n",
      (n * sxy - sx * sy) / (n * sxx - sx * sx)}' "$run/growth"
}

echo "Load average $(load); seconds of work, the least of $ROUNDS processes${one:+ on one processor}."
echo
table_of_the_paper
cat <<'TEXT'

Points, triangles, and what a closed surface of genus 0 lacks of twice the points (4 there); init: reading and sorting;
the paper's columns are its table 1, of a 250 MHz R10000; times: its reconstruction time over ours; axis: the variant of
its section 6.1, which projects on the nearest axis plane. The stand-ins are closed, the paper's models were scanned.

TEXT
growth
cat <<'TEXT'
Peak memory is the process's, a point's share of it without the program, with the points as read (24 bytes each) and
their triangles (24); the rest is what the cloud and the algorithm take.
TEXT
echo "Load average $(load)."
