#!/bin/sh
# A subscriber of libdexel outlives the service, killed or stopped, and holds the mesh of the next one: outlive.c.
set -eu
. tests/daemon.sh
cat >"$run/reconnect.yaml" <<EOF
socket: $run/mesh.sock
control_socket: $run/control.sock
streams:
  - name: box
    synthetic: {scene: moving-box, size: 160x120, noise: 0.003, fps: 20}
EOF
"$B/tests/outlive" "$B/bin/dexeld" "$run/reconnect.yaml" "$run/mesh.sock"
