#!/bin/sh
# A service whose standard error is the journal's speaks to the journal itself, here one of our own in a mount namespace:
# its lines say which stream, which device and which client they are about, whatever thread they are of.
set -eu
if [ "${1:-}" != inside ]; then
  unshare -m true 2>/dev/null || { echo "no mount namespace can be made"; exit 77; }
  exec unshare -m sh "$0" inside
fi
command -v python3 >/dev/null || { echo "there is no python3"; exit 77; }
mount -t tmpfs tmpfs /run 2>/dev/null || { echo "cannot mount a tmpfs"; exit 77; }
. tests/daemon.sh
dexel=$B/bin/dexel
wrong() { echo "$1"; cat "$run/journal" "$run/dexeld.log"; exit 1; }
pids=
leave() {
  [ -z "$dexeld_pid" ] || stop_dexeld || true
  # shellcheck disable=SC2086 # words
  [ -z "$pids" ] || kill $pids 2>/dev/null || true
  at_exit
}
trap leave EXIT

# a line for each datagram, its fields between bars
mkdir -p /run/systemd/journal
mkfifo "$run/bound" "$run/sim"
: >"$run/journal"
python3 -c '
import socket, sys
s = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
s.bind("/run/systemd/journal/socket")
open(sys.argv[1], "w").write("bound\n")
with open(sys.argv[2], "a", buffering=1) as out:
    while True:
        out.write("|" + s.recv(4096).decode().replace("\n", "|") + "\n")
' "$run/bound" "$run/journal" &
pids=$!
read -r _ <"$run/bound"

"$B/tests/scip_sim" --tcp 0 --rpm 30 >"$run/sim" &
pids="$pids $!"
read -r port <"$run/sim" || wrong 'no simulator'
cat >"$run/c.yaml" <<EOF2
socket: $run/mesh.sock
control_socket: $run/mesh.sock.control
streams:
  - name: turret
    hokuyo: {tcp: '127.0.0.1:$port', stage: {rpm: 30, columns: 60}}
  - name: box
    synthetic: {scene: moving-box, size: 80x60}
    record: {path: $run/box.mcap}
EOF2
: >"$run/dexeld.log"
JOURNAL_STREAM=$(stat -c %d:%i "$run/dexeld.log")
export JOURNAL_STREAM
start_dexeld -c "$run/c.yaml"
"$dexel" cat --socket "$run/mesh.sock" --stream box --quiet 2>/dev/null &
cat_pid=$!

line() { # line WHAT PATTERN...: one datagram matches all patterns
  what=$1 tries=0
  shift
  until matching "$@"; do
    tries=$((tries + 1))
    [ $tries -lt 3000 ] || wrong "$what: no line of $*"
  done
}
matching() {
  found=$(cat "$run/journal")
  for pattern in "$@"; do found=$(echo "$found" | grep -e "$pattern") || return 1; done
}
line 'the reader' '|MESSAGE=reader: turret: streaming' '|SYSLOG_IDENTIFIER=dexeld|' '|STREAM=turret|' '|SUBSYSTEM=reader|' \
  '|PRIORITY=6|'
line 'the recorder' '|MESSAGE=recorder: box: recording to' '|STREAM=box|'
line 'the loop' '|MESSAGE=server: client 1 .*: subscribed to box' '|STREAM=box|' "|CLIENT_PID=$cat_pid|" "|CLIENT_UID=$(id -u)|"
kill "${pids##* }" # the scanner goes; its line names the one that was there
line 'the device' '|MESSAGE=reader: turret: \(gone\|faulted\)' '|STREAM=turret|' '|DEVICE=[^|]'
stop_dexeld || wrong 'dexeld failed'
line 'the end' '|MESSAGE=server: stopping: SIGTERM|'
! grep 'stopping: SIGTERM' "$run/journal" | grep 'STREAM=\|CLIENT_PID=' || wrong 'the end is about nobody'
[ ! -s "$run/dexeld.log" ] || wrong 'standard error was used as well'
wait $cat_pid || true
