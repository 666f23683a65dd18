#!/bin/sh
# Ours beside PCL's OrganizedFastMesh and VTK's structured grids on the same simulated scans (hall, 1 cm noise,
# 2 % drop-outs), in turn within this run, because machines are shared: ready ranges -> f32 chunks (publish, codes,
# f32) against ready points -> triangles. Each figure is the median, with minimum and maximum, of ROUNDS runs of a
# program, which itself tells the median of FRAMES frames. The programs run on one processor, `dexel` with two threads
# apart.
#   bench_peers.sh [--markdown]     SIZES="columnsxrows ..."  ROUNDS=N
set -eu
B=${B:-build}
ROUNDS=${ROUNDS:-5}
FRAMES=3
SIZES=${SIZES:-600x400 640x480 2048x128 1280x720 1500x1000 10000x4000}
LARGE=8000000 # dexels; above them one round of one frame, PCL's first way alone, no edges counted: that takes minutes
SCAN="--noise 0.01 --dropouts 0.02"
markdown=
line='%-38s %9.2f %9.2f %9.2f %10s %10s %7s %6.2f'
if [ "${1:-}" = --markdown ]; then
  markdown=1
  line='| %s | %.2f | %.2f | %.2f | %s | %s | %s | %.2f |'
fi

skip() { echo "bench-peers: skipped: $1"; exit 0; }

. tests/peers/pcl.sh
build_pcl pcl_ofm
. tests/peers/vtk.sh
pcl=$B/peers/pcl_ofm

run=$(mktemp -d)
trap 'rm -rf "$run"' EXIT
one=
if command -v taskset >/dev/null && taskset -c 0 true 2>/dev/null; then one="taskset -c 0"; fi

number() { grep -o "\"$1\": [0-9.]*" "$2" | sed 's/.*: //'; }

# ---- measuring: milliseconds of each way go to $run/WAY.ms, the rest of the last run stays ------------------------
ours() { # WAY SIZE THREADS [PREFIX]
  # shellcheck disable=SC2086 # lists of words
  ${4:-} "$B/bin/dexel" bench --json --rounds $frames --size "$2" --threads "$3" $SCAN f32 >"$run/$1"
  number f32_ms "$run/$1" >>"$run/$1.ms"
}

peer() { # OUTPUT PROGRAM ARGUMENTS...: a line for each of its ways
  out=$run/$1
  shift
  $one "$@" >"$out"
  awk -v d="$run" '$1 != "peak_rss_mb" {print $2 >>(d "/" $1 ".ms")}' "$out"
}

one_round() { # SIZE
  ours one "$1" 1 "$one"
  ours two "$1" 2
  if [ "$large" ]; then peer pcl "$pcl" "$run/scan.pcd" $frames limited; return; fi
  peer pcl "$pcl" "$run/scan.pcd" $frames
  [ -z "$vtk" ] || [ -e "$run/grid.ms" ] || peer vtk "$vtk" "$run/scan.pcd" $frames # slow: in the first round alone
}

# ---- telling ------------------------------------------------------------------------------------------------------
row() { # LABEL WAY TRIANGLES BOUNDARY RSS
  sort -n "$run/$2.ms" | awk -v label="$1" -v t="$3" -v e="$4" -v rss="$5" -v ours="$ours" -v line="$line" '
    {v[NR] = $1}
    END {m = v[int((NR + 1) / 2)]; printf line "\n", label, m, v[1], v[NR], t, e, rss, m / ours}'
}

our_row() { # LABEL WAY
  row "$1" "$2" "$triangles" "$boundary" "$(number resident_bytes "$run/$2" | awk '{printf "%.0f", $1 / 1048576}')"
}

peer_row() { # LABEL WAY OUTPUT: nothing when that was not measured
  [ -e "$run/$2.ms" ] || return 0
  # shellcheck disable=SC2046 # two numbers
  row "$1" "$2" $(awk -v w="$2" '$1 == w {print $3, $4}' "$run/$3") "$(awk '$1 == "peak_rss_mb" {print $2}' "$run/$3")"
}

table() { # SIZE
  ours=$(sort -n "$run/one.ms" | awk '{v[NR] = $1} END {print v[int((NR + 1) / 2)]}')
  triangles=$(number f32_triangles "$run/one" | awk '{printf "%.0f", $1}') boundary=-
  if [ -z "$large" ]; then
    "$B/bin/dexel" mesh "$run/scan.pcd" --stats >"$run/stats"
    triangles=$(number triangles "$run/stats") boundary=$(number boundary_edges "$run/stats")
  fi
  if [ "$markdown" ]; then
    printf '\n| %s | median, ms | min | max | triangles | boundary | RSS, MB | ratio |\n' "$1"
    echo '|---|---:|---:|---:|---:|---:|---:|---:|'
  else
    printf '\n%-38s %9s %9s %9s %10s %10s %7s %6s\n' "$1" 'median ms' min max triangles boundary 'RSS MB' ratio
  fi
  our_row "dexel, ranges -> f32 chunks" one
  our_row "dexel, two threads" two
  peer_row "PCL adaptive cut, edges <= 0.1 m" limited pcl
  peer_row "PCL right cut, 12.5 degrees" defaults pcl
  peer_row "VTK grid, no limit" grid vtk
  peer_row "VTK grid, cells with sides <= 0.1 m" grid_limited vtk
}

load() { cut -d' ' -f1-3 /proc/loadavg; }

echo "Load average $(load); medians of $ROUNDS runs of $FRAMES frames${one:+, all but the two threads on one processor}."
for size in $SIZES; do
  rm -f "$run"/*.ms
  large= frames=$FRAMES rounds=$ROUNDS
  if [ $((${size%x*} * ${size#*x})) -gt $LARGE ]; then large=1 frames=1 rounds=1; fi
  # shellcheck disable=SC2086 # a list of words
  "$B/bin/dexel" sim hall -o "$run/scan.pcd" --size "$size" $SCAN
  k=0
  while [ $k -lt "$rounds" ]; do
    one_round "$size"
    k=$((k + 1))
  done
  table "$size"
done
cat <<'TEXT'

ratio: to the median of dexel with one thread, whose chunks go through one buffer; the others keep their triangles.
Triangles and boundary edges are those of the scan's file; only dexel closes the seam of the full turn and bridges
drop-outs. RSS: the process's peak, its input, tables and libraries included. PCL's and VTK's output memory is used again.
VTK: vtkStructuredGrid with blanked points, its surface filter, vtkTriangleFilter; it has no rule for edges, so that the
second way blanks long cells as its users must; it is run in the first round alone. Above 8 million dexels: one frame,
PCL's first way alone, and boundary edges are not counted.
TEXT
echo "Load average $(load)."
