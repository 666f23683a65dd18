# Killed, it is back, and who connects meanwhile gets a mesh from the new one; who was connected sees the end.
# limit: 300
set -eu
. tests/hil/devices.sh
. tests/hil/installed.sh

pid=$(shown MainPID)
dexel cat --quiet -o /run/hil/follower.ply 2>/run/hil/follower &
follower=$!
await 60 is_connected $follower
kill -KILL "$pid"
meshed
has NRestarts 1
[ "$(shown MainPID)" != "$pid" ] || wrong 'the same process'
if wait $follower; then wrong 'a subscriber has not seen that the service was killed'; fi
cat /run/hil/follower

pid=$(shown MainPID)
kill -ABRT "$pid"
meshed
has NRestarts 2

# told to end, it stays ended
kill -TERM "$(shown MainPID)"
await 60 is ActiveState inactive
has Result success
systemctl start dexeld.service
has NRestarts 0
