# A service that does not tell that it lives is killed by the watchdog, and is back. Its time is set shorter here.
# limit: 300
set -eu
. tests/hil/devices.sh
. tests/hil/installed.sh

drop_in <<CONF
WatchdogSec=5
CONF
systemctl restart dexeld.service
has WatchdogUSec 5s
pid=$(shown MainPID)
kill -STOP "$pid"
await 60 is NRestarts 1
await 60 is ActiveState active
[ "$(shown MainPID)" != "$pid" ] || wrong 'the same process'
journalctl -q --no-pager -o cat -u dexeld.service | grep 'Watchdog timeout'
meshed
