#!/bin/sh
# make gallery: pictures of reconstructed clouds with their triangles drawn, in docs/gallery/, and docs/gallery.md, which
# shows them with the commands that made them. All clouds are of analytic surfaces (dexel sim --surface --list), so that
# anyone gets the same points. A row below is a picture; one of a mode that this build has not is left out.
set -eu
B=${B:-build}
dexel="$B/bin/dexel"
out=docs/gallery
page=docs/gallery.md
size=600x500
most=150000 # bytes of a picture: they stay in the history for ever
run=$(mktemp -d)
trap 'rm -rf "$run"' EXIT
mkdir -p "$out"

value() { sed -n 's/.*"'"$1"'": \([-+.0-9a-z]*\).*/\1/p' "$run/stats"; }

# picture NAME TITLE TEXT "surface and its options" "mode and its options" VIEW
picture() {
  mode=${5%% *}
  "$dexel" mesh --mode "$mode" --help >/dev/null 2>&1 || { echo "gallery: no mode $mode: without $1" >&2; return 0; }
  # shellcheck disable=SC2086 # lists of words
  "$dexel" sim --surface $4 -o "$run/cloud.xyz"
  # shellcheck disable=SC2086
  "$dexel" mesh --mode $5 "$run/cloud.xyz" -o "$run/mesh.ply" --stats >"$run/stats" 2>"$run/log"
  "$dexel" render "$run/mesh.ply" -o "$out/$1.png" --edges --few-colours --size $size --view "$6"
  [ "$(wc -c <"$out/$1.png")" -le $most ] || { echo "gallery: $out/$1.png has more than $most bytes" >&2; exit 1; }
  cat <<TEXT
## $2

![$2](gallery/$1.png)

$3
$(value input_points) points, $(value triangles) triangles, $(value boundary_edges) boundary edges, $(value components) components.

    dexel sim --surface $4 -o cloud.xyz
    dexel mesh --mode $5 cloud.xyz -o mesh.ply
    dexel render mesh.ply -o $1.png --edges --few-colours --size $size --view $6

TEXT
  echo "gallery: $out/$1.png" >&2
}

{
  cat <<'TEXT'
# Gallery

Meshes of points that come without an order, with their triangles drawn; printed by `make gallery`.
[clouds.md](clouds.md) tells what the modes do. The points are of analytic surfaces at random places, the noise is along
the normal, in spacings.

TEXT
  picture project-double-torus "Two handles" "Projection closes a surface of any genus." \
    "double-torus --points 3000" "project" 20,50
  picture project-bumpy "Bumps" "Points of even density." "bumpy --points 2000" "project" iso
  picture project-torus "A torus, random points" "Density changes from place to place; no point is left out." \
    "random-torus --points 2400" "project" 30,40
  picture project-plate "A plate with holes" "Five handles, and two sheets that lie close to each other." \
    "plate --points 3000" "project" iso
  picture project-cylinder "A tube" "Rims stay open: no surface is made where there are no points." \
    "cylinder --points 1500" "project" iso
  picture project-noise "Noise of half the spacing" \
    "The mesh goes through all points it can, so it is as rough as they are, and has holes; it stays a manifold." \
    "random-bumpy --points 3000 --noise 0.5" "project" iso
  picture project-repair "The same, mended" "\`--repair\` closes what is small." \
    "random-bumpy --points 3000 --noise 0.5" "project --repair" iso
  picture delaunay-double-torus "Two handles, by localized Delaunay" "Every triangle has an empty circle." "double-torus --points 2400" "delaunay" 20,50
  picture delaunay-bumpy "Bumps, by localized Delaunay" "Points of even density." "bumpy --points 1500" "delaunay" iso
  picture smooth-noise "Noise of half the spacing, smoothed" "The surface under the points, with fewer triangles where it is flat." \
    "random-bumpy --points 6000 --noise 0.5" "smooth" iso
  picture smooth-double-torus "Two handles, noise, smoothed" \
    "Where the surface is curved there are more and smaller triangles." \
    "double-torus --points 8000 --noise 0.5" "smooth --repair" 20,50
} >"$run/page"
sed -e :a -e '/^\n*$/{$d;N;ba' -e '}' "$run/page" >"$page"
