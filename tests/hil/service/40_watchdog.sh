# A service that does not tell that it lives is killed by the watchdog, and is back. Its time is set shorter here.
# limit: 60
set -eu
. tests/hil/devices.sh
. tests/hil/installed.sh

drop_in <<CONF
WatchdogSec=3
CONF
systemctl restart dexeld.service
has WatchdogUSec 3s
pid=$(shown MainPID)
kill -STOP "$pid"
await 20 is NRestarts 1
await 20 is ActiveState active
[ "$(shown MainPID)" != "$pid" ] || wrong 'the same process'
journalctl -q --no-pager -o cat -u dexeld.service | grep 'Watchdog timeout'
meshed
