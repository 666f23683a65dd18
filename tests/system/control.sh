#!/bin/sh
# What an operator asks a running dexeld for: its clients and to disconnect one, its log level, the devices that it sees,
# to end; that the log tells who changed something; and what a subscriber is told here.
set -u
. "$(dirname "$0")/../expect.sh"

cat >control.yaml <<END
socket: $run/mesh.sock
control_socket: $run/control.sock
streams:
  - name: box
    synthetic: {scene: moving-box, size: 160x120, fps: 20}
END
start_dexeld -c control.yaml || exit 1

# one that stays, and is told why it ends
mkfifo said
exec 8<>said
"$dexel" cat --socket mesh.sock >&8 2>&1 &
client=$!
timeout 300 grep -q -m 1 '160 x 120 dexels' <&8 || fail "a client was told nothing"
expect 0 "$dexel" clients --socket control.sock
number=$(awk -v pid=$client '$2 == pid && $4 == "box" {print $1}' out)
[ -n "$number" ] || fail "the client $client is not listed: $(cat out)"
expect 0 "$dexel" clients --socket control.sock --json
says "\"number\":$number" out
expect 1 "$dexel" clients --socket control.sock --disconnect 999999
says 'the service: no client of number 999999'
expect 0 "$dexel" clients --socket control.sock --disconnect "$number"
says '1 disconnected' out
wait $client && fail "a client that was disconnected ended well"
timeout 300 grep -q -m 1 'disconnected by an operator' <&8 || fail "it was not told why"
exec 8>&-
says "pid $client" dexeld.log
grep -q "control: pid [0-9]* uid $(id -u) asked for .*\"disconnect\"" dexeld.log || fail "the log does not tell who asked"

expect 0 "$dexel" log-level --socket control.sock
[ "$(cat out)" = info ] || fail "the level is '$(cat out)', expected info"
expect 0 "$dexel" log-level debug --socket control.sock
[ "$(cat out)" = debug ] || fail "the level is '$(cat out)', expected debug"
expect 0 "$dexel" cat --socket mesh.sock --frames 1
says ': connected' dexeld.log # of debug
expect 1 "$dexel" log-level loud --socket control.sock
says 'expected error, warning, notice, info or debug'
[ "$(grep -c 'asked for .*log-level' dexeld.log)" = 1 ] || fail "the log tells more changes than there were"

# a subscriber is told that it is at the wrong socket, and does not try again
for how in '' --reconnect; do
  expect 1 timeout 300 "$dexel" cat --socket control.sock $how
  says 'this seems to be the control socket, but this needs the mesh socket'
done
grep -q "control: pid [0-9]* uid $(id -u): found a control byte" dexeld.log || fail "the log does not tell of a subscriber"

expect 0 "$dexel" devices --socket control.sock
expect 0 "$dexel" devices --service --socket control.sock --json
grep -q '^{"devices":\[.*\],"errors":\[\]}$' out || fail "devices of the service: $(cat out)"

for words in 'clients more' 'clients --disconnect 0' 'clients --disconnect 1x' 'log-level debug info' 'log-level --stream box' \
  'quit now' 'devices --service more'; do
  # shellcheck disable=SC2086 # words
  expect 2 "$dexel" $words
done

expect 0 "$dexel" quit --socket control.sock
wait "$dexeld_pid" || fail "the service ended with status $?"
dexeld_pid=
grep -q 'asked for {"request":"quit"}' dexeld.log || fail "the log does not tell who ended it"
expect 1 "$dexel" quit --socket control.sock
exit $bad
