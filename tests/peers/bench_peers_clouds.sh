#!/bin/sh
# Unorganized points: ours, by each mode that this build has, beside CGAL's advancing front, PCL's greedy projection and
# Open3D's ball pivoting on the same points, in turn within this run, because machines are shared. Each figure is the
# least, with the median, of ROUNDS processes, each on one processor, of the seconds that it worked: others on the machine
# disturb those less than the time of day. Reading and writing files are left out, the peers' normals are told apart. What the meshes are is counted by dexel mesh --report for all. The bunny is meshed when
# $DEXEL_DATA has it.
#   bench_peers_clouds.sh [--markdown]    CLOUDS="surface:points:noise[:rounds] ..." (noise in spacings)  ROUNDS=N
#   LARGE=1: half a million points as well; with noise CGAL takes minutes, so that this one is measured once
set -eu
B=${B:-build}
ROUNDS=${ROUNDS:-3}
CLOUDS=${CLOUDS:-random-bumpy:83034:0 random-bumpy:83034:0.4 random-bumpy:34817:0}
[ -z "${LARGE:-}" ] || CLOUDS="$CLOUDS random-bumpy:500000:0 random-bumpy:500000:1:1"
bunny=${DEXEL_DATA:-}/points/bunny.orig.m.gz
markdown=
line='%-24s %8.3f %8.3f %7.2f %8s %6s %9s %8s %7s %7s %8s %8s %8s %6.2f %8s'
head='%-24s %8s %8s %7s %8s %6s %9s %8s %7s %7s %8s %8s %8s %6s %8s'
if [ "${1:-}" = --markdown ]; then
  markdown=1
  line='| %s | %.3f | %.3f | %.2f | %s | %s | %s | %s | %s | %s | %s | %s | %s | %.2f | %s |'
  head='| %s | %s | %s | %s | %s | %s | %s | %s | %s | %s | %s | %s | %s | %s | %s |'
fi

say() { echo "bench-peers-clouds: $*" >&2; }
skip() { echo "bench-peers-clouds: skipped: $1"; exit 0; }

. tests/peers/build_peer.sh
command -v g++ >/dev/null || skip "no g++"
# peer_of NAME HEADER PACKAGE INCLUDES LIBRARIES: builds it, and adds its name to $peers; without what it needs, says so
peers=
peer_of() {
  if install_for_peers "$2" "$3" && build_peer "$1" "$4" "$5"; then
    peers="$peers $1"
  else
    say "without $1: it needs $3"
  fi
}
peer_of cgal_front /usr/include/CGAL/Advancing_front_surface_reconstruction.h libcgal-dev \
  "-DNDEBUG -frounding-math" "-lgmp -lmpfr"
for header in /usr/include/pcl-1.*/pcl/surface/gp3.h; do
  install_for_peers "$header" libpcl-dev || true
done
for header in /usr/include/pcl-1.*/pcl/surface/gp3.h; do
  pcl=${header%/pcl/surface/gp3.h}
done
peer_of pcl_greedy "$pcl/pcl/surface/gp3.h" libpcl-dev "-isystem $pcl -isystem /usr/include/eigen3" \
  "-lpcl_surface -lpcl_features -lpcl_search -lpcl_kdtree -lpcl_common"
peer_of o3d_pivot /usr/include/open3d/geometry/TriangleMesh.h libopen3d-dev \
  "-isystem /usr/include/open3d -isystem /usr/include/eigen3" "-lOpen3D -lfmt -ltbb"
[ "$peers" ] || skip "no peer"

run=$(mktemp -d)
trap 'rm -rf "$run"' EXIT
one=
if command -v taskset >/dev/null && taskset -c 0 true 2>/dev/null; then one="taskset -c 0"; fi
dexel=$B/bin/dexel
modes=
for mode in project delaunay smooth; do
  if "$dexel" mesh --mode $mode --help >/dev/null 2>&1; then modes="$modes $mode"; fi
done

value() { sed -n 's/.*"'"$1"'": \([-+.0-9a-z]*\).*/\1/p' "$2"; }

# ---- measuring: seconds of each way go to $run/WAY.s, its normals and megabytes to WAY.of, its last mesh to WAY.ply ------
ours() { # MODE
  $one "$dexel" mesh --mode "$1" "$run/points.xyz" --threads 1 -o "$run/$1.ply" --stats >"$run/stats" 2>"$run/$1.log" ||
    { say "$1 failed: $(tail -n 1 "$run/$1.log")"; return 0; }
  awk -v a="$(value load_cpu_seconds "$run/stats")" -v b="$(value mesh_cpu_seconds "$run/stats")" 'BEGIN {print a + b}' \
    >>"$run/$1.s"
  awk -v n="$(value peak_rss_bytes "$run/stats")" 'BEGIN {printf "- %.0f\n", n / 1048576}' >"$run/$1.of"
}

peer() { # NAME
  $one "$B/peers/$1" "$run/points.xyz" "$run/$1.ply" >"$run/figures" 2>"$run/$1.log" ||
    { say "$1 failed: $(tail -n 1 "$run/$1.log")"; return 0; }
  awk '{print $1}' "$run/figures" >>"$run/$1.s"
  awk '{if ($2 > 0) printf "%.2f %s\n", $2, $3; else print "-", $3}' "$run/figures" >"$run/$1.of"
}

# ---- telling ------------------------------------------------------------------------------------------------------
least() { sort -n "$1" | head -n 1; }

row() { # LABEL WAY
  [ -e "$run/$2.s" ] || return 0
  truth=-
  "$dexel" mesh --report "$run/$2.ply" --stats >"$run/report"
  if [ -e "$run/truth.xyz" ]; then
    "$dexel" mesh --report "$run/$2.ply" --points "$run/truth.xyz" --stats >"$run/distance"
    truth=$(sed -n 's/.*"rms": \([-+.0-9e]*\).*/\1/p' "$run/distance" | awk '{printf "%.2f", 1000 * $1}')
  fi
  sort -n "$run/$2.s" | awk -v label="$1" -v line="$line" -v ours="$ours" -v of="$(cat "$run/$2.of")" -v truth="$truth" \
    -v t="$(value triangles "$run/report")" -v b="$(value boundary_edges "$run/report")" \
    -v l="$(value boundary_loops "$run/report")" -v e="$(value nonmanifold_edges "$run/report")" \
    -v v="$(value nonmanifold_vertices "$run/report")" -v d="$(value duplicate_directed_edges "$run/report")" \
    -v s="$(value share_below_10_deg "$run/report")" -v c="$(value crossing_triangles "$run/report")" '
    {x[NR] = $1}
    END {split(of, f, " ")
      printf line "\n", label, x[1], x[int((NR + 1) / 2)], x[1] / ours, f[1], f[2], t, b, l, e, v, d, c, 100 * s, truth}'
}

table() { # LABEL ROUNDS; the points are in $run/points.xyz
  rm -f "$run"/*.s
  k=0
  while [ $k -lt "$2" ]; do
    for mode in $modes; do ours "$mode"; done
    for peer in $peers; do peer "$peer"; done
    k=$((k + 1))
  done
  [ -e "$run/project.s" ] || return 0
  ours=$(least "$run/project.s")
  printf '\n%s, %s points; %s; %s runs\n' "$1" "$(wc -l <"$run/points.xyz")" \
    "$(sed -n 's/.*; \(spacing [^;]*\).*/\1/p' "$run/project.log")" "$2"
  # shellcheck disable=SC2059 # a format of ours
  printf "${markdown:+\n}$head\n" '' 'least s' median ratio normals MB triangles boundary loops edges+ bow-tie unlike crossing '% <10' \
    truth
  [ -z "$markdown" ] || echo '|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|'
  for mode in $modes; do row "dexel $mode" "$mode"; done
  row "CGAL advancing front" cgal_front
  row "PCL gp3" pcl_greedy
  row "Open3D ball pivoting" o3d_pivot
}

load() { cut -d' ' -f1-3 /proc/loadavg; }

echo "Load average $(load); seconds of work, least and median of $ROUNDS processes${one:+, each on one processor}."
for cloud in $CLOUDS; do
  # shellcheck disable=SC2046 # words
  set -- $(echo "$cloud" | tr : ' ')
  "$dexel" sim --surface "$1" -o "$run/points.xyz" --points "$2" --noise "$3"
  rm -f "$run/truth.xyz"
  [ "$3" = 0 ] || "$dexel" sim --surface "$1" -o "$run/truth.xyz" --points "$2"
  table "$1, noise $3 spacings" "${4:-$ROUNDS}"
done
if [ -e "$bunny" ]; then
  rm -f "$run/truth.xyz"
  gzip -dc "$bunny" | awk '$1 == "Vertex" {print $3, $4, $5}' >"$run/points.xyz"
  table bunny "$ROUNDS"
fi
cat <<'TEXT'

ratio: of the least time to that of dexel project with one thread, loading (lattice, dexels) and meshing; normals: seconds
before that, where a peer needs them; MB: peak of the process. boundary: edges of one triangle; loops: sets of them;
edges+: edges of three triangles or more; bow-tie: vertices of several fans; unlike: times an edge runs twice in one
direction, which is 0 where all triangles agree on their side; crossing: triangles that go through others; % <10: triangles with an angle below 10 degrees; truth: root
mean square distance of points of the surface without noise from the mesh, in thousandths of the model's radius.
TEXT
echo "Load average $(load)."
