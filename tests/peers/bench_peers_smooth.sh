#!/bin/sh
# Smoothing of noisy points: dexel convert --smooth beside CGAL's jet and bilateral smoothing, on the same points, in turn
# within this run, each on one processor. What is left is measured against the true surface: a sphere, and a cube, whose
# edges tell what smoothing does to creases. Reading and writing files are left out of the times.
#   bench_peers_smooth.sh      POINTS=N (35000)  NOISE="0.26 0.5" (spacings)  ROUNDS=N (3)
set -eu
B=${B:-build}
POINTS=${POINTS:-35000}
NOISE=${NOISE:-0.26 0.5}
ROUNDS=${ROUNDS:-3}

skip() { echo "bench-peers-smooth: skipped: $1"; exit 0; }

. tests/peers/build_peer.sh
install_for_peers /usr/include/CGAL/jet_smooth_point_set.h libcgal-dev ||
  skip "libcgal-dev is not there and could not be installed"
[ -e /usr/include/eigen3/Eigen/Dense ] || install_for_peers /usr/include/eigen3/Eigen/Dense libeigen3-dev ||
  skip "no libeigen3-dev"
command -v g++ >/dev/null || skip "no g++"
build_peer cgal_smooth "-DNDEBUG -DCGAL_EIGEN3_ENABLED -isystem /usr/include/eigen3" "-lgmp -lmpfr"

run=$(mktemp -d)
trap 'rm -rf "$run"' EXIT
one=
if command -v taskset >/dev/null && taskset -c 0 true 2>/dev/null; then one="taskset -c 0"; fi
dexel=$B/bin/dexel

# A cube of half side 1, independent points; noise along the normals of its faces. To points.xyz and true.xyz.
cube() { # POINTS NOISE
  awk -v n="$1" -v noise="$2" -v true="$run/true.xyz" 'BEGIN {srand(7); h = sqrt(24 / n)
    for (k = 0; k < n; k++) {
      face = k % 6; a = int(face / 2); s = face % 2 ? 1 : -1
      p[a] = s; p[(a + 1) % 3] = 2 * rand() - 1; p[(a + 2) % 3] = 2 * rand() - 1
      printf "%.9g %.9g %.9g\n", p[0], p[1], p[2] >true
      p[a] += noise * h * s * sqrt(-2 * log(1 - rand())) * cos(6.283185307 * rand())
      printf "%.9g %.9g %.9g\n", p[0], p[1], p[2]}}' >"$run/points.xyz"
}

# What is left of the noise, in spacings: all points, and of a cube those whose true place is within two spacings of an edge.
error() { # sphere|cube POINTS FILE
  paste -d' ' "$run/true.xyz" "$3" | awk -v n="$2" -v cube="$([ "$1" = cube ] && echo 1)" '
    function abs(x) {return x < 0 ? -x : x}
    function max(x, y) {return x > y ? x : y}
    BEGIN {h = sqrt((cube ? 24 : 12.566370614) / n)}
    {if (!cube) d = sqrt($4 ^ 2 + $5 ^ 2 + $6 ^ 2) - 1
     else {
       x = abs($4) - 1; y = abs($5) - 1; z = abs($6) - 1; out = sqrt(max(x, 0) ^ 2 + max(y, 0) ^ 2 + max(z, 0) ^ 2)
       d = out > 0 ? out : max(max(x, y), z)
       a = abs($1); b = abs($2); c = abs($3); second = a + b + c - max(max(a, b), c) - (a < b ? a < c ? a : c : b < c ? b : c)
       if (second > 1 - 2 * h) {near += d * d; n_near++}
     }
     sum += d * d; count++}
    END {printf "%.4f %s", sqrt(sum / count) / h, n_near ? sprintf("%.4f", sqrt(near / n_near) / h) : "-"}'
}

median() { sort -n "$1" | awk '{x[NR] = $1} END {print x[int((NR + 1) / 2)]}'; }

row() { # LABEL FILE SECONDS_FILE SHAPE
  # shellcheck disable=SC2046 # two words
  printf '%-28s %9.2f %9s %9s\n' "$1" "$(awk -v s="$(median "$3")" -v n="$POINTS" 'BEGIN {print 1e6 * s / n}')" \
    $(error "$4" "$POINTS" "$2")
}

table() { # SHAPE NOISE
  rm -f "$run"/*.s
  k=0
  while [ $k -lt "$ROUNDS" ]; do
    for way in plane quadric; do
      $one "$dexel" mesh --mode smooth --stages smooth "$run/points.xyz" --threads 1 --stats --fit $way \
        -o "$run/mesh.ply" >"$run/stats" 2>"$run/log.$way"
      sed -n 's/.*"stages": {"smooth": \([0-9.e+-]*\).*/\1/p' "$run/stats" >>"$run/$way.s"
    done
    for way in jet bilateral; do
      $one "$B/peers/cgal_smooth" $way "$run/points.xyz" "$run/$way.xyz" >"$run/figures"
      awk '{print $1 + $2}' "$run/figures" >>"$run/$way.s"
    done
    k=$((k + 1))
  done
  for way in plane quadric; do
    "$dexel" convert --smooth "$run/points.xyz" "$run/$way.xyz" --fit $way --threads 1 2>/dev/null
  done
  printf '\n%s, %s points, noise %s spacings; dexel: %s\n' "$1" "$POINTS" "$2" \
    "$(sed -n 's/.*; \(sw [^:]*\):.*/\1/p' "$run/log.plane")"
  printf '%-28s %9s %9s %9s\n' '' 'us/point' rms 'at edges'
  cp "$run/points.xyz" "$run/none.xyz"
  echo 0 >"$run/none.s"
  for way in none plane quadric jet bilateral; do
    case $way in
      none) label="as measured" ;;
      plane | quadric) label="dexel, $way" ;;
      jet) label="CGAL jet, k = 24" ;;
      *) label="CGAL bilateral with normals" ;;
    esac
    row "$label" "$run/$way.xyz" "$run/$way.s" "$1"
  done
}

load() { cut -d' ' -f1-3 /proc/loadavg; }

echo "Load average $(load); medians of $ROUNDS processes${one:+, each on one processor}."
for noise in $NOISE; do
  "$dexel" sim --surface random-sphere -o "$run/points.xyz" --points "$POINTS" --noise "$noise"
  "$dexel" sim --surface random-sphere -o "$run/true.xyz" --points "$POINTS" --noise 0
  table sphere "$noise"
  cube "$POINTS" "$noise"
  table cube "$noise"
done
cat <<'TEXT'

rms: of the distance from the true surface, in spacings, the side of the square that a point has of it. at edges: of points
within two spacings of an edge of the cube.
TEXT
echo "Load average $(load)."
