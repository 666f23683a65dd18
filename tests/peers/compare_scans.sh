#!/bin/sh
# The meshes of real scans beside PCL's OrganizedFastMesh, in numbers: a Markdown table (docs/scans.md says
# what the columns mean). All meshes are counted from their PLY files by one program.
#   FACTOR=3   PCL's longest edge, in 95th percentiles of the distance between neighbours
#   KEEP=DIR   leaves the scans as PCD and all meshes as PLY in DIR
set -eu
B=${B:-build}
DATA=${DEXEL_DATA:-../shared/data}
FACTOR=${FACTOR:-3}

skip() { echo "compare-scans: skipped: $1"; exit 0; }

[ -d "$DATA" ] || skip "no scans at $DATA (\$DEXEL_DATA)"
. tests/peers/pcl.sh
build_pcl pcl_mesh

if [ -n "${KEEP:-}" ]; then run=$KEEP && mkdir -p "$run"
else run=$(mktemp -d) && trap 'rm -rf "$run"' EXIT; fi

number() { grep -o "\"$1\": [0-9.]*" "$2" | sed 's/.*: //'; }

row() { # LABEL MESH [BRIDGED]
  # shellcheck disable=SC2046 # a list of numbers
  set -- "$1" "${3:-0}" $("$B/peers/mesh_counts" "$2")
  awk -v label="$1" -v bridged="$2" -v p="$3" -v t="$4" -v boundary="$5" -v components="$6" -v odd="$7" \
    -v grazing="$8" -v valid="$valid" -v full="$full" 'BEGIN {
      printf "| %-26s | %7d | %6.2f | %6.2f | %5d | %6d | %5d | %3d | %5.2f |\n", label, t, 100 * p / valid,
        100 * (t - bridged) / full, bridged, boundary, components, odd, 100 * grazing / t}'
}

compare() { # NAME FILE: FILE is what dexel reads; PCL reads $run/NAME.pcd
  "$B/peers/pcl_mesh" "$run/$1.pcd" "$run/$1" "$FACTOR" >"$run/scan"
  read -r valid full edge <"$run/scan"
  "$B/bin/dexel" mesh "$2" -o "$run/$1.ply" --stats >"$run/stats"
  "$B/bin/dexel" mesh "$2" --bridge 0 --stats >"$run/open"
  sigma=$(sed 's/.*"sigma": \[\([^]]*\)\].*/\1/' "$run/stats" |
    awk -F', ' '{printf "%.2f mm + %.2f mm/m2", 1000 * $1, 1000 * $3}')
  printf '| **%s** %s x %s, %d valid, noise %s | | | | | | | | |\n' "$1" "$(number height "$run/stats")" \
    "$(number width "$run/stats")" "$valid" "$sigma"
  row dexel "$run/$1.ply" $(($(number triangles "$run/stats") - $(number triangles "$run/open")))
  row "PCL adaptive, <= ${edge%?} m" "$run/$1-adaptive.ply"
  row "PCL defaults" "$run/$1-defaults.ply"
}

depth() { # NAME FILE UNIT_M FX FY CX CY
  name=$1
  file=$2
  shift 2
  "$B/peers/depth_pcd" "$file" "$run/$name.pcd" "$@"
  compare "$name" "$run/$name.pcd"
}

cat <<'TEXT'
| | triangles | used % | coverage % | bridged | boundary | parts | non-manifold | grazing % |
|---|---|---|---|---|---|---|---|---|
TEXT
if [ -e "$DATA/ptx/pump.ptx.gz" ]; then
  "$B/bin/dexel" convert --format pcd "$DATA/ptx/pump.ptx.gz" "$run/pump.pcd"
  compare pump "$DATA/ptx/pump.ptx.gz"
fi
for f in "$DATA"/pcd/*.pcd; do
  [ -e "$f" ] || continue
  name=$(basename "$f" .pcd)
  cp "$f" "$run/$name.pcd"
  compare "$name" "$f"
done
# Millimetres; the camera of the Redwood scans.
for f in "$DATA"/depth/open3d/*.png; do
  [ ! -e "$f" ] || depth "$(basename "$f" .png)" "$f" 0.001 525 525 319.5 239.5
done
# Millimetres and the camera, as the book's own program reads these images (ch5/rgbd/joinMap.cpp).
for f in "$DATA"/depth/slambook/*.pgm; do
  [ ! -e "$f" ] || depth "$(basename "$f" .pgm)" "$f" 0.001 518 519 325.5 253.5
done
cat <<TEXT

PCL $(pkg-config --modversion pcl_surface), longest edge $FACTOR times the 95th percentile of the distance between neighbours. No reader
yet, so not here: Ouster and Velodyne (pcap), E57. Load average $(cut -d' ' -f1-3 /proc/loadavg).
TEXT
