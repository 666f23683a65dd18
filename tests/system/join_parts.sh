#!/bin/sh
# Subscribers that join while a slow frame comes in, part by part: each gets whole chunks of one array (dexels
# lose their return between the frames, so codes of one and samples of another would be refused).
set -eu
. tests/daemon.sh

cat >"$run/dexeld.yaml" <<EOF
socket: $run/mesh.sock
control_socket: $run/control.sock
streams:
  - name: slow
    synthetic: {scene: hall, size: 260x200, fps: 2, parts: 1, noise: 0.01, dropouts: 0.4}
    commit_ms: 1000
    mesh: {sigma: [0.01, 0, 0]}
EOF
start_dexeld -c "$run/dexeld.yaml"
n=0
while [ $n -lt 20 ]; do
  n=$((n + 1))
  "$B/bin/dexel" cat --socket "$run/mesh.sock" --encoding q16 --frames 2 --stats --quiet >"$run/q16"
  "$B/bin/dexel" cat --socket "$run/mesh.sock" --encoding f32 --frames 1 --stats --quiet >"$run/f32"
  grep -q '"duplicate_directed_edges": 0' "$run/q16"
done
stop_dexeld
