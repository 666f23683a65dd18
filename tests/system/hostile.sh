#!/bin/sh
# Clients that do all they can do wrong, beside one that must not notice: hostile.c.
set -eu
. tests/daemon.sh
renice -n -10 $$ >/dev/null 2>&1 || true

cat >"$run/hostile.yaml" <<EOF
socket: $run/mesh.sock
control_socket: $run/control.sock
log_level: warning
streams:
  - name: box
    synthetic: {scene: moving-box, size: 320x240, fps: 10}
EOF
start_dexeld -c "$run/hostile.yaml"
"$B/tests/hostile" "$run/mesh.sock" "$run/control.sock" "$dexeld_pid" || { cat "$run/dexeld.log"; exit 1; }
stop_dexeld
