#!/bin/sh
# kill -9 while the daemon records, at random instants: what was recorded until at most a second before (and what
# a busy machine adds) is there, nothing of it is altered, and it replays.
set -eu
. tests/daemon.sh
wrong() { echo "$1"; cat "$run/dexeld.log"; exit 1; }
n_kills=${N_KILLS:-8}
cat >"$run/c.yaml" <<YAML
socket: $run/mesh.sock
control_socket: $run/mesh.sock.control
streams:
  - name: box
    synthetic: {scene: moving-box, size: 32x24, fps: 400}
    record: {path: "$run/box.mcap", split_s: 1}
YAML
worst=0
k=0
while [ $k -lt "$n_kills" ]; do
  rm -f "$run"/box*.mcap
  start_dexeld -c "$run/c.yaml"
  # a random instant of the first two seconds: chunks of the first file, the next file's beginning
  sleep "$(od -An -N2 -tu2 /dev/urandom | awk '{printf "%.3f", $1 / 32768}')"
  killed=$(date +%s%N)
  kill -9 "$dexeld_pid"
  wait "$dexeld_pid" 2>/dev/null || true
  dexeld_pid=
  k=$((k + 1))
  [ -e "$run/box.mcap" ] || continue # before its first block
  ls "$run"/box*.mcap | while read -r f; do [ "$(wc -c <"$f")" -ge 8 ] || rm "$f"; done # the magic itself is cut
  "$B/tests/record_check" --synthetic "$run"/box*.mcap >"$run/out" || wrong "kill $k: $(cat "$run/out")"
  grep -q ' lost 0 ' "$run/out" || wrong "kill $k: $(cat "$run/out")"
  last=$(sed 's/.* end_ns //' "$run/out")
  [ "$last" -gt 0 ] || continue # before its first whole chunk
  rm -rf "$run/kept"
  mkdir "$run/kept"
  cp "$run"/box*.mcap "$run/kept"
  n=$(sed 's/blocks \([0-9]*\) .*/\1/' "$run/out")
  age_ms=$(((killed - last) / 1000000))
  [ $age_ms -lt 3000 ] || wrong "kill $k: the last block is $age_ms ms old"
  [ $age_ms -le $worst ] || worst=$age_ms
done
[ $worst -gt 0 ] || wrong "nothing was ever recorded"
echo "$k kills, at most $worst ms lost"

start_dexeld --replay "$run/kept" --rate max --socket "$run/mesh.sock"
"$B/bin/dexel" cat --socket "$run/mesh.sock" --lossless --stats --quiet >"$run/stats"
stop_dexeld
grep -q "\"frame\": $((n - 1)), \"frames_missed\": 0, \"dropped\": 0," "$run/stats" || wrong "replay of $n: $(cat "$run/stats")"
