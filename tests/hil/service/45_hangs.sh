# One thread of the service hangs, the loop, a reader or a mesher, and all others go on: the watchdog kills it, the journal says
# which it was, and the service is back. The fault is put in by a program of the tests (tests/faults).
# limit: 300
set -eu
. tests/hil/devices.sh
. tests/hil/installed.sh

was_restarted() { [ "$(shown NRestarts)" -ge 1 ]; }
for thread in loop reader mesher; do
  since=$(date +%s)
  drop_in <<CONF
WatchdogSec=5
Environment=DEXELD_FAULT=hang-$thread:5
ExecStart=
ExecStart=/hil/bin/dexeld_faults -c $config
CONF
  systemctl restart dexeld.service
  # who comes next does not hang
  drop_in <<CONF
WatchdogSec=5
CONF
  await 60 was_restarted
  await 60 is ActiveState active
  journalctl -q --no-pager -o cat -u dexeld.service --since "@$since" >/run/hil/journal
  grep "^fault: hang-$thread" /run/hil/journal
  grep 'Watchdog timeout' /run/hil/journal
  [ $thread = loop ] || grep "watchdog: hall: the $thread hangs" /run/hil/journal
  meshed
done
