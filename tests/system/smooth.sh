#!/bin/sh
# Smoothed ranges through the service are those of `dexel mesh --smooth`, in every encoding, and subscribers
# are told; with exact points they are refused.
set -eu
. tests/daemon.sh

config() { # MESH-OPTIONS FILE-OPTIONS
  cat >"$run/dexeld.yaml" <<YAML
socket: $run/mesh.sock
control_socket: $run/control.sock
streams:
  - name: smooth
    mesh: {$1}
    file: {path: $run/scan.pcd, rate: max, lossless: yes, wait: 1$2}
YAML
}

"$B/bin/dexel" sim hall -o "$run/scan.pcd" --size 200x130 --noise 0.01 --dropouts 0.02 --attr 8
for smooth in on off; do
  option=$([ $smooth = off ] || echo --smooth)
  told=$([ $smooth = off ] && echo false || echo true)
  # shellcheck disable=SC2086 # a word or none
  "$B/bin/dexel" mesh "$run/scan.pcd" $option -o "$run/$smooth.ply" --stats | grep -q "\"smoothed\": $told"
  config "smooth: $smooth" ""
  for encoding in f32 q16 delta; do
    start_dexeld -c "$run/dexeld.yaml"
    "$B/bin/dexel" cat --socket "$run/mesh.sock" --lossless --encoding $encoding --stats \
      -o "$run/cat.ply" >"$run/stats" 2>"$run/words"
    stop_dexeld
    cmp "$run/$smooth.ply" "$run/cat.ply"
    grep -q "\"smoothed\": $told" "$run/stats"
    [ "$(grep -c ', smoothed$' "$run/words")" = "$([ $smooth = on ] && echo 1 || echo 0)" ]
  done
done
if cmp -s "$run/on.ply" "$run/off.ply"; then exit 1; fi

config "smooth: on" ", exact: yes"
if "$B/bin/dexeld" -c "$run/dexeld.yaml" 2>"$run/why"; then exit 1; fi
grep -q 'exact points need smooth off' "$run/why"
if "$B/bin/dexel" mesh "$run/scan.pcd" --exact --smooth -o "$run/no.ply" 2>"$run/why"; then exit 1; fi
grep -q 'exact points need smooth off' "$run/why"
