# dexeld runs in the guest: what a subscriber gets of a replay is, bit for bit, the mesh that the host made.
set -eu
. tests/daemon.sh

start_dexeld --replay expected/hall.pcd --rate max --wait 1 --socket "$run/mesh.sock"
for encoding in f32 q16; do
  dexel cat --socket "$run/mesh.sock" --encoding $encoding --lossless --quiet -o "$run/hall.ply"
  (cd "$run" && sha256sum -c /expected/hall.sha256)
done
stop_dexeld
