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

# No part is a commit of its own before commit_ms, the first one neither: two frames, two commits at most.
cat >"$run/late.yaml" <<EOC
socket: $run/mesh.sock
control_socket: $run/control.sock
streams:
  - name: late
    commit_ms: 60000
    synthetic: {scene: moving-box, size: 160x120, fps: $fps, parts: 20, frames: 2, wait: 1}
    mesh: {sigma: 0.002}
EOC
start_dexeld -c "$run/late.yaml"
"$B/bin/dexel" cat --socket "$run/mesh.sock" --stats --quiet >"$run/late.json"
stop_dexeld
n=$(sed 's/.*"commits": \([0-9]*\),.*/\1/' "$run/late.json")
[ "$n" = 1 ] || [ "$n" = 2 ] || { echo "$n commits of two frames: $(cat "$run/late.json")"; exit 1; }
