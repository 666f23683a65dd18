#!/bin/sh
# A replay of a directory at rate max: lossless subscribers in both encodings get every frame, and each commit is
# the mesh that `dexel mesh` makes of that frame. It waits for as many as it was told. A live stream refuses them.
set -eu
. tests/daemon.sh
dexel=$B/bin/dexel
frames=12
wrong() { echo "$1"; exit 1; }
status() { "$dexel" status --socket "$run/mesh.sock" --json; }

"$dexel" sim moving-box -o "$run/scan" --format pcd --size 160x120 --noise 0.002 --dropouts 0.01 --frames $frames
n=0
while [ $n -lt $frames ]; do
  "$dexel" mesh "$run/scan" --frame $n -o "$run/mesh-$(printf %06d $n).ply"
  n=$((n + 1))
done

# the first alone gets nothing; the log is a pipe, to wait for its line
mkfifo "$run/dexeld.log"
exec 8<>"$run/dexeld.log"
start_dexeld --replay "$run/scan" --rate max --wait 2 --socket "$run/mesh.sock"
"$dexel" cat --socket "$run/mesh.sock" --lossless --encoding q16 -o "$run/q16-%06d.ply" --every --stats --quiet >"$run/q16.json" &
first=$!
timeout 300 grep -q -m 1 'subscribed to replay' <&8 || wrong "the first did not subscribe"
status | grep -q '"state":"opening".*"frames":0,.*"subscribers":1' || wrong "it began with one subscriber: $(status)"
"$dexel" cat --socket "$run/mesh.sock" --lossless --encoding f32 -o "$run/f32-%06d.ply" --every --stats --quiet >"$run/f32.json"
wait $first
status | grep -q '"state":"ended"' || wrong "not ended: $(status)"
stop_dexeld

for e in q16 f32; do
  grep -q "\"commits\": $frames, \"frame\": $((frames - 1)), \"frames_missed\": 0, \"dropped\": 0," "$run/$e.json" || wrong "$e: $(cat "$run/$e.json")"
  for mesh in "$run"/mesh-*.ply; do cmp "$mesh" "$run/$e-${mesh##*-}"; done
done
[ "$(cksum <"$run/mesh-000000.ply")" != "$(cksum <"$run/mesh-000011.ply")" ] || wrong "all frames are the same"

# an endless stream is no replay at rate max
cat >"$run/live.yaml" <<EOF
socket: $run/mesh.sock
control_socket: $run/control.sock
streams:
  - name: box
    synthetic: {scene: moving-box, size: 64x48}
EOF
start_dexeld -c "$run/live.yaml"
code=0
timeout 300 "$dexel" cat --socket "$run/mesh.sock" --lossless 2>"$run/err" || code=$?
[ $code = 1 ] || wrong "lossless of a live stream: status $code"
grep -q 'lossless is only for a replay at rate max' "$run/err" || wrong "$(cat "$run/err")"
"$dexel" cat --socket "$run/mesh.sock" --frames 1 --quiet
stop_dexeld
