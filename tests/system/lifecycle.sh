#!/bin/sh
# How dexeld starts and ends: sockets made, replaced, refused and removed; SIGTERM with clients and while a replay
# waits; socket activation; what it says when it cannot start.
set -u
. tests/daemon.sh
dexel=$B/bin/dexel
dexeld=$B/bin/dexeld
sock=$run/mesh.sock
bad=0
wrong() { echo "wrong: $*"; bad=1; }
now_ms() { echo $(($(date +%s%N) / 1000000)); }

# fails STATUS TEXT COMMAND...: it exits so, saying that
fails() {
  want=$1 text=$2
  shift 2
  code=0
  timeout 300 "$@" >"$run/said" 2>&1 || code=$?
  [ $code = "$want" ] || wrong "$*: status $code, expected $want"
  [ -z "$text" ] || grep -qF -- "$text" "$run/said" || wrong "$*: said '$(cat "$run/said")', expected '$text'"
}

# config FILE [LINE OF THE STREAM...]
config() {
  printf 'socket: %s\ncontrol_socket: %s.control\nstreams:\n  - name: box\n    synthetic: {scene: moving-box, size: 160x120, noise: 0.001}\n' "$sock" "$sock" >"$1"
}
config "$run/good.yaml"

# ends: SIGTERM; status 0, within the five seconds that a busy machine may need, sockets gone
ends() {
  start=$(now_ms)
  stop_dexeld || wrong "$1: status $dexeld_status after SIGTERM"
  took=$(($(now_ms) - start))
  echo "$1: ended $took ms after SIGTERM"
  [ $took -lt 5000 ] || ! "$B/tests/sanitized" || wrong "$1: took $took ms to end"
  [ -z "$(ls -d "$sock"* 2>/dev/null)" ] || wrong "$1: left $(ls -d "$sock"*)"
}

start_dexeld -c "$run/good.yaml" || exit 1
for s in "$sock" "$sock.control"; do
  [ "$(stat -c %a "$s")" = 660 ] || wrong "$s has mode $(stat -c %a "$s"), expected 660"
done

# one service at an address
fails 1 "$sock.lock: another service has this socket" "$dexeld" -c "$run/good.yaml"
"$dexel" cat --socket "$sock" --frames 2 --quiet || wrong "the first service was disturbed"

# with clients: one that reads, and one that was stopped and has a message half written to it
mkfifo "$run/said.cat"
exec 8<>"$run/said.cat"
"$dexel" cat --socket "$sock" --encoding f32 >&8 2>&1 &
stopped=$!
timeout 300 grep -q -m 1 '160 x 120 dexels' <&8 || wrong "a client was told nothing"
kill -STOP $stopped
"$dexel" cat --socket "$sock" --encoding q16 >&8 2>&1 &
client=$!
timeout 300 grep -q -m 1 '160 x 120 dexels' <&8 || wrong "a client was told nothing"
"$dexel" cat --socket "$sock" --frames 5 --quiet || wrong "a client beside a stopped one has no mesh"
ends "live, with clients"
kill -CONT $stopped
for c in $client $stopped; do
  code=0
  wait $c || code=$?
  [ $code = 1 ] || wrong "a client of a service that stops: status $code, expected 1"
done
exec 8>&-

# while a replay waits for its subscribers
"$dexel" sim sphere -o "$run/scan.pcd" --size 60x40 || exit 1
start_dexeld --replay "$run/scan.pcd" --rate max --wait 3 --socket "$sock" || exit 1
ends "replay that waits"

# a socket that nobody answers at is replaced; what is no socket is not
start_dexeld -c "$run/good.yaml" || exit 1
kill -9 "$dexeld_pid"
wait "$dexeld_pid"
[ -S "$sock" ] || wrong "kill -9 left no socket to try this with"
start_dexeld -c "$run/good.yaml" || exit 1
"$dexel" cat --socket "$sock" --frames 1 --quiet || wrong "no service at the replaced socket"
ends "after a stale socket"
echo precious >"$sock"
fails 1 "$sock: found something that is no socket" "$dexeld" -c "$run/good.yaml"
[ "$(cat "$sock")" = precious ] || wrong "a file at the socket's path was touched"
rm -f "$sock"

# sockets of the service manager
if command -v systemd-socket-activate >/dev/null; then
  mkfifo "$run/activate"
  exec 7<>"$run/activate"
  systemd-socket-activate -l "$sock" -l "$sock.control" --fdname=mesh:control \
    "$dexeld" -c "$run/good.yaml" 2>"$run/activate" &
  dexeld_pid=$!
  timeout 300 grep -m 2 'Listening on' <&7 >"$run/said" || wrong "systemd-socket-activate does not listen"
  timeout 300 "$dexel" cat --socket "$sock" --frames 2 --quiet || wrong "activated: no mesh"
  timeout 300 "$dexel" status --socket "$sock" >/dev/null || wrong "activated: no status"
  "$dexel" config --socket "$sock" | grep -q '^socket: .*# not in use' || wrong "activated: the configured socket is told to be in use"
  stop_dexeld || wrong "activated: status $dexeld_status"
  [ -S "$sock" ] || wrong "an inherited socket was removed"
  rm -f "$sock" "$sock.control"
else
  echo "no systemd-socket-activate: socket activation is not tested"
fi

# what cannot be started
mkdir "$run/empty"
fails 1 "$run/none.pcd" "$dexeld" --replay "$run/none.pcd" --socket "$sock"
fails 1 "$run/empty" "$dexeld" --replay "$run/empty" --socket "$sock"
fails 1 "$run/none.yaml" "$dexeld" -c "$run/none.yaml"
fails 1 "$run/none/mesh.sock" "$dexeld" --replay "$run/scan.pcd" --socket "$run/none/mesh.sock"
fails 2 "--replay needs --socket" "$dexeld" --replay "$run/scan.pcd"
fails 2 "-c and --replay" "$dexeld"
[ ! -e "$sock" ] || wrong "a service that did not start left a socket"

fails 0 '' "$dexeld" -c "$run/good.yaml" --check
sed 's/noise: 0.001/noise: much/' "$run/good.yaml" >"$run/noise.yaml"
fails 1 "$run/noise.yaml:5:" "$dexeld" -c "$run/noise.yaml" --check
fails 1 "streams[0].synthetic.noise" "$dexeld" -c "$run/noise.yaml"
sed 's/size:/sise:/' "$run/good.yaml" >"$run/key.yaml"
fails 1 "$run/key.yaml:5:" "$dexeld" -c "$run/key.yaml" --check
printf 'streams: [\n' >"$run/broken.yaml"
fails 1 "$run/broken.yaml:2:1" "$dexeld" -c "$run/broken.yaml" --check
printf 'socket: %s\nstreams: []\n' "$sock" >"$run/no.yaml"
fails 1 "$run/no.yaml:2:" "$dexeld" -c "$run/no.yaml" --check
exit $bad
