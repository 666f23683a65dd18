# A recording of the service, made by an operator, is replayed by an instance of its own unit, within that unit's sandbox.
# limit: 300
set -eu
. tests/hil/devices.sh
. tests/hil/installed.sh

rm -f /var/lib/dexeld/*.mcap
dexel record start
recorded_some() { [ "$(counted blocks)" -ge 4 ]; }
await 60 recorded_some
is_batch() { for t in /proc/"$(shown MainPID)"/task/*/sched; do grep '^policy .*: *3$' "$t" && return; done; return 1; }
await 60 is_batch
dexel record stop
is_whole() { dexel info /var/lib/dexeld/hall.mcap | grep -q '^sound *yes'; }
await 60 is_whole
systemctl start dexeld-replay@hall.service
has SubState running dexeld-replay@hall.service
meshed --socket /run/dexeld-replay/hall/mesh.sock
systemctl stop dexeld-replay@hall.service
has Result success dexeld-replay@hall.service
[ ! -e /run/dexeld-replay/hall ] || wrong 'its folder is left'
systemd-analyze security --threshold=10 dexeld-replay@hall.service >/dev/null || wrong 'more exposed than docs/operations.md says'
