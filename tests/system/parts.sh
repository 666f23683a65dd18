#!/bin/sh
# A frame that arrives in columns is at its end the same mesh as one that arrives whole: parts.c.
set -eu
. tests/daemon.sh
fps=10
"$B/tests/sanitized" || fps=2

cat >"$run/parts.yaml" <<EOF
socket: $run/mesh.sock
control_socket: $run/control.sock
streams:
  - name: whole
    synthetic: {scene: moving-box, size: 160x120, noise: 0.002, dropouts: 0.01, fps: $fps}
    mesh: {sigma: 0.002}
  - name: parts
    commit_ms: 10
    synthetic: {scene: moving-box, size: 160x120, noise: 0.002, dropouts: 0.01, fps: $fps, parts: 20}
    mesh: {sigma: 0.002}
EOF
start_dexeld -c "$run/parts.yaml"
"$B/tests/parts" "$run/mesh.sock"
stop_dexeld
