#!/bin/sh
# Late joiners hold what early subscribers hold: late.c. With noise every tile changes in every frame.
set -eu
. tests/daemon.sh

cat >"$run/late.yaml" <<EOF
socket: $run/mesh.sock
control_socket: $run/control.sock
streams:
  - name: box
    synthetic: {scene: moving-box, size: 640x480, noise: 0.003, fps: 10}
EOF
start_dexeld -c "$run/late.yaml"
"$B/tests/late" "$run/mesh.sock"
"$B/bin/dexel" status --socket "$run/control.sock"
stop_dexeld
