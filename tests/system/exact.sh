#!/bin/sh
# Exact points through the service are those of `dexel mesh --exact`; encodings of ranges are refused.
set -eu
. tests/daemon.sh

"$B/bin/dexel" sim hall -o "$run/scan.pcd" --size 200x130 --noise 0.003 --dropouts 0.02
"$B/bin/dexel" mesh "$run/scan.pcd" --exact -o "$run/mesh.ply"
cat >"$run/dexeld.yaml" <<YAML
socket: $run/mesh.sock
control_socket: $run/control.sock
streams:
  - name: exact
    file: {path: $run/scan.pcd, rate: max, lossless: yes, wait: 1, exact: yes}
YAML
start_dexeld -c "$run/dexeld.yaml"
if "$B/bin/dexel" cat --socket "$run/mesh.sock" --encoding q16 --quiet 2>"$run/refused"; then exit 1; fi
grep 'exact points' "$run/refused"
stop_dexeld
start_dexeld -c "$run/dexeld.yaml"
"$B/bin/dexel" cat --socket "$run/mesh.sock" --lossless --quiet -o "$run/cat.ply"
stop_dexeld
cmp "$run/mesh.ply" "$run/cat.ply"
for refused in '--encoding delta' '--filter mean' '--size 50x40 --keep mean'; do
  # shellcheck disable=SC2086 # words
  if "$B/bin/dexel" mesh "$run/scan.pcd" --exact $refused -o "$run/no.ply" 2>"$run/why"; then exit 1; fi
  grep -q 'exact' "$run/why"
done
