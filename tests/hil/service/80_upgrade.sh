# A later version is installed over it: the configuration that was changed stays, the service is the new one's, its sockets are
# those of before, and who subscribes meanwhile gets a mesh.
# limit: 300
set -eu
. tests/hil/devices.sh
. tests/hil/installed.sh

cp $config /run/hil/config
pid=$(shown MainPID)
sockets() { stat -c '%n %i' $run/mesh.sock $run/control.sock; }
before=$(sockets)
dpkg --force-confold -i debs/next/dexeld_*.deb &
upgrade=$!
gone() { [ ! -d "/proc/$pid" ]; }
await 60 gone
meshed
wait $upgrade
case $(dpkg-query -W -f '${Status} ${Version}' dexeld) in 'install ok installed '*+later) ;; *) wrong 'the later version is not installed' ;; esac
[ "$(sockets)" = "$before" ] || wrong "sockets are others: $(sockets), not $before"
cmp $config /run/hil/config
grep 'of a later version' $config.dpkg-dist
has ActiveState active
has NRestarts 0
systemctl is-enabled --quiet dexeld.service dexeld.socket dexeld-control.socket
meshed
