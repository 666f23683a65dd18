#!/bin/sh
# dexel status --watch: a live screen on a terminal (status_watch.py); elsewhere a block a second, with no code in it, which
# ends with the service.
set -eu
. tests/daemon.sh
command -v python3 >/dev/null || { echo "there is no python3"; exit 77; }
dexel=$B/bin/dexel
wrong() { echo "$1"; cat "$run/dexeld.log"; exit 1; }
cat >"$run/c.yaml" <<EOF2
socket: $run/mesh.sock
control_socket: $run/mesh.sock.control
streams:
  - name: box
    synthetic: {scene: moving-box, size: 160x120, fps: 30}
  - name: still
    synthetic: {scene: hall, size: 200x100, frames: 3, fps: 50}
EOF2
start_dexeld -c "$run/c.yaml"
"$dexel" cat --socket "$run/mesh.sock" --stream box --quiet 2>/dev/null &
cat_pid=$!
tries=0
until "$dexel" status --socket "$run/mesh.sock" | grep -q " $cat_pid .* box "; do
  tries=$((tries + 1))
  [ $tries -lt 3000 ] || wrong 'no client'
done

timeout 300 python3 tests/system/status_watch.py "$run/mesh.sock" "$dexel" || wrong 'on a terminal'

# two blocks, by way of a pipe that is closed then
"$dexel" status --watch --socket "$run/mesh.sock" 2>/dev/null | sed '/^memory /{x;s/^/x/;/xx/{x;q;};x;}' >"$run/blocks"
[ "$(grep -c '^STREAM .* P99 MS' "$run/blocks")" = 2 ] || wrong "blocks: $(cat "$run/blocks")"
[ "$(grep -c "^box .* live " "$run/blocks")" = 2 ] || wrong "blocks: $(cat "$run/blocks")"
! LC_ALL=C grep -q "$(printf '\033')" "$run/blocks" || wrong 'codes in a pipe'

# the service goes: so do they, and say why
for form in --watch '--watch --json'; do
  mkfifo "$run/pipe"
  # shellcheck disable=SC2086 # words
  timeout 300 "$dexel" status $form --socket "$run/mesh.sock" 2>"$run/err" >"$run/pipe" &
  watch_pid=$!
  exec 8<"$run/pipe"
  read -r _ <&8 || wrong "$form: nothing"
  stop_dexeld || wrong 'dexeld failed'
  cat <&8 >/dev/null
  code=0
  wait $watch_pid || code=$?
  [ $code = 1 ] || wrong "$form: status $code"
  grep -q 'mesh.sock.control: ' "$run/err" || wrong "$form: $(cat "$run/err")"
  rm "$run/pipe"
  start_dexeld -c "$run/c.yaml"
done
stop_dexeld || wrong 'dexeld failed'
wait $cat_pid || true
