# Reloaded by systemctl with clients connected: the stream that changed begins anew with its subscriber, the other one goes on; a
# file that is not right is refused, and changes nothing.
# limit: 300
set -eu
. tests/hil/devices.sh
. tests/hil/installed.sh

cat >>$config <<YAML
  - name: room
    synthetic: {scene: stairs, size: 60x40, fps: 5}
YAML
systemctl reload dexeld.service
streams() { status | grep -o '"name":"[a-z]*"' | tr -d '\n'; }
has_room() { [ "$(streams)" = '"name":"hall""name":"room"' ]; }
await 60 has_room

dexel cat --quiet --stream hall &
hall=$!
dexel cat --quiet --stream room &
room=$!
await 60 is_connected $hall
await 60 is_connected $room
pid=$(shown MainPID)

sed -i 's/60x40/90x60/' $config
systemctl reload dexeld.service
is_wider() { status | grep -q '"width":90'; }
await 60 is_wider
await 60 is StatusText '2 streams, 2 live; 2 clients'
is_connected $hall && is_connected $room || wrong 'a subscriber has lost its connection'
meshed --stream room

cp $config /run/hil/config
sed -i 's/90x60/ninety/' $config
if systemctl reload dexeld.service; then wrong 'a file that is not right was taken'; fi
journalctl -q --no-pager -o cat -u dexeld.service | grep "found 'ninety'"
await 60 is ActiveState active
has MainPID "$pid"
has NRestarts 0
is_connected $hall && is_connected $room || wrong 'a refused reload has cost a connection'
cp /run/hil/config $config
kill $hall $room
small_scene
