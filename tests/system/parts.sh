#!/bin/sh
# A frame that arrives in columns is at its end the same mesh as one that arrives whole: parts.c.
set -eu
. tests/daemon.sh

cat >"$run/parts.yaml" <<EOF
socket: $run/mesh.sock
control_socket: $run/control.sock
streams:
  - name: whole
    synthetic: {scene: moving-box, size: 320x240, noise: 0.002, dropouts: 0.01, fps: 10}
    mesh: {sigma: 0.002}
  - name: parts
    commit_ms: 10
    synthetic: {scene: moving-box, size: 320x240, noise: 0.002, dropouts: 0.01, fps: 10, parts: 40}
    mesh: {sigma: 0.002}
EOF
start_dexeld -c "$run/parts.yaml"
"$B/tests/parts" "$run/mesh.sock"
stop_dexeld
