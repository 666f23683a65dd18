#!/bin/sh
# make demo: simulates a scan, replays it through the service to a subscriber, shows what came out. With a
# real scan in $DEXEL_DATA, does the same with that. Leaves build/demo/*.ply and *.png; stops what it
# started.
set -eu
B=${B:-build}
out=$B/demo
rm -rf "$out"
mkdir -p "$out"
. "$(dirname "$0")/daemon.sh"

say() { printf '\n== %s\n' "$*"; }

# through SOURCE NAME RATE CAT-OPTIONS...: the service replays SOURCE, `dexel cat` writes NAME.ply
through() {
  source=$1 name=$2 rate=$3
  shift 3
  start_dexeld --replay "$source" --rate "$rate" --loop --wait 1 --socket "$run/$name.sock"
  "$B/bin/dexel" cat --socket "$run/$name.sock" --encoding q16 "$@" -o "$out/$name.ply"
  "$B/bin/dexel" status --socket "$run/$name.sock"
  stop_dexeld
  "$B/bin/dexel" render "$out/$name.ply" -o "$out/$name.png"
}

say 'simulating a hall: 900x600 dexels, 4 mm of noise, 1 % drop-outs, 5 frames'
"$B/bin/dexel" sim hall -o "$run/hall" --format pcd --size 900x600 --noise 0.004 --dropouts 0.01 \
  --frames 5 --attr 16
say 'replaying it at 10 frames a second through dexeld to a subscriber'
through "$run/hall" hall real --frames 30

scan=${DEXEL_DATA:-}/ptx/pump.ptx.gz
if [ -e "$scan" ]; then
  say "the same with a real scan: $(basename "$scan")"
  through "$scan" scan real --frames 1
fi

say 'done. What came out of the subscriber:'
ls -l "$out"/*.ply "$out"/*.png
cat <<EOF

Look at the pictures, or open a .ply in MeshLab, CloudCompare or Blender. Then try:
  $B/bin/dexel mesh YOUR.ptx -o mesh.ply --stats      a scan of yours, without the service
  $B/bin/dexel sim --list                             the simulated scenes
  $B/bin/dexel cat --help                             what a subscriber can ask for
  $B/bin/dexeld -c config/dexeld.yaml --check         the service's configuration
EOF
