#!/bin/sh
# Unorganized points: ours beside CGAL's advancing front and PCL's greedy projection on the same points, in turn within
# this run, because machines are shared. Each figure is the median, with minimum and maximum, of ROUNDS processes, each
# on one processor; reading and writing files are left out, PCL's normals are told apart. What the meshes are is counted
# by dexel mesh --report for all. The bunny is meshed when $DEXEL_DATA has it.
#   bench_peers_clouds.sh      CLOUDS="surface:points:noise ..." (noise in spacings)  ROUNDS=N
# Half a million points with noise, where CGAL takes minutes: CLOUDS="random-bumpy:500000:0 random-bumpy:500000:1"
set -eu
B=${B:-build}
ROUNDS=${ROUNDS:-3}
CLOUDS=${CLOUDS:-random-bumpy:83034:0 random-bumpy:83034:0.4}
bunny=${DEXEL_DATA:-}/points/bunny.orig.m.gz

skip() { echo "bench-peers-clouds: skipped: $1"; exit 0; }

. tests/peers/build_peer.sh
install_for_peers /usr/include/CGAL/Advancing_front_surface_reconstruction.h libcgal-dev ||
  skip "libcgal-dev is not there and could not be installed"
command -v g++ >/dev/null || skip "no g++"
build_peer cgal_front "-DNDEBUG -frounding-math" "-lgmp -lmpfr"
pcl=
for header in /usr/include/pcl-1.*/pcl/surface/gp3.h; do
  if [ -e "$header" ]; then
    build_peer pcl_greedy "$(pkg-config --cflags-only-I pcl_features pcl_surface eigen3 | sed 's/-I/-isystem /g')" \
      "-lpcl_surface -lpcl_features -lpcl_search -lpcl_kdtree -lpcl_common"
    pcl=$B/peers/pcl_greedy
  else
    echo "bench-peers-clouds: without PCL: no libpcl-dev"
  fi
done

run=$(mktemp -d)
trap 'rm -rf "$run"' EXIT
one=
if command -v taskset >/dev/null && taskset -c 0 true 2>/dev/null; then one="taskset -c 0"; fi
dexel=$B/bin/dexel

value() { sed -n 's/.*"'"$1"'": \([-+.0-9a-z]*\).*/\1/p' "$2"; }

# ---- measuring: seconds of each way go to $run/WAY.s, the mesh of the last run stays ------------------------------
ours() {
  $one "$dexel" mesh --mode project "$run/points.xyz" --threads 1 -o "$run/dexel.ply" --stats >"$run/stats" 2>"$run/log"
  awk -v a="$(value load_seconds "$run/stats")" -v b="$(value mesh_seconds "$run/stats")" 'BEGIN {print a + b}' \
    >>"$run/dexel.s"
}

peer() { # WAY PROGRAM: the seconds of its normals are in $run/WAY.normals
  $one "$2" "$run/points.xyz" "$run/$1.ply" >"$run/figures"
  awk '{print $1}' "$run/figures" >>"$run/$1.s"
  awk '{print $2}' "$run/figures" >"$run/$1.normals"
}

# ---- telling ------------------------------------------------------------------------------------------------------
row() { # LABEL WAY
  [ -e "$run/$2.s" ] || return 0
  "$dexel" mesh --report "$run/$2.ply" --stats >"$run/report"
  sort -n "$run/$2.s" | awk -v label="$1" -v ours="$ours" -v t="$(value triangles "$run/report")" \
    -v b="$(value boundary_edges "$run/report")" -v l="$(value boundary_loops "$run/report")" \
    -v e="$(value nonmanifold_edges "$run/report")" -v v="$(value nonmanifold_vertices "$run/report")" \
    -v d="$(value duplicate_directed_edges "$run/report")" -v s="$(value share_below_10_deg "$run/report")" '
    {x[NR] = $1}
    END {m = x[int((NR + 1) / 2)]
      printf "%-24s %9.4f %9.4f %9.4f %7.2f %9s %9s %7s %7s %7s %8s %6.2f\n", label, m, x[1], x[NR], m / ours, t, b, l, e, v,
        d, 100 * s}'
}

median() { sort -n "$1" | awk '{x[NR] = $1} END {print x[int((NR + 1) / 2)]}'; }

table() { # LABEL; the points are in $run/points.xyz
  rm -f "$run"/*.s
  k=0
  while [ $k -lt "$ROUNDS" ]; do
    ours
    peer cgal "$B/peers/cgal_front"
    [ -z "$pcl" ] || peer pcl "$pcl"
    k=$((k + 1))
  done
  ours=$(median "$run/dexel.s")
  printf '\n%s, %s points; %s\n' "$1" "$(wc -l <"$run/points.xyz")" "$(sed 's/.*; spacing/spacing/;s/; at most.*//' "$run/log")"
  printf '%-24s %9s %9s %9s %7s %9s %9s %7s %7s %7s %8s %6s\n' '' 'median s' min max ratio triangles boundary loops \
    edges+ bow-tie unlike '% <10'
  row dexel dexel
  row "CGAL advancing front" cgal
  row "PCL gp3" pcl
  [ -z "$pcl" ] || echo "PCL's normals before that: $(cat "$run/pcl.normals") s"
}

load() { cut -d' ' -f1-3 /proc/loadavg; }

echo "Load average $(load); medians of $ROUNDS processes${one:+, each on one processor}."
for cloud in $CLOUDS; do
  surface=${cloud%%:*} rest=${cloud#*:}
  "$dexel" sim --surface "$surface" -o "$run/points.xyz" --points "${rest%:*}" --noise "${rest#*:}"
  table "$surface, noise ${rest#*:} spacings"
done
if [ -e "$bunny" ]; then
  gzip -dc "$bunny" | awk '$1 == "Vertex" {print $3, $4, $5}' >"$run/points.xyz"
  table bunny
fi
cat <<'TEXT'

ratio: to the median of dexel with one thread, loading (lattice, dexels) and meshing. boundary: edges of one triangle;
loops: sets of them; edges+: edges of three triangles or more; bow-tie: vertices of several fans; unlike: times an edge runs
twice in one direction, which is 0 where all triangles agree on their side; % <10: triangles with an angle below 10 degrees.
TEXT
echo "Load average $(load)."
