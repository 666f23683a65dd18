# The packages as they are: the service is enabled and runs from then on, as its own user, watched; its sockets are there for their groups
# alone; systemd finds nothing to say of its units; nothing is warned of. The tests after this one find it installed.
# limit: 300
set -eu
. tests/hil/devices.sh
. tests/hil/installed.sh

everything >/run/hil/before
dpkg -i debs/*.deb
await 60 is ActiveState active
has SubState running
has NRestarts 0
# as GROUP COMMAND...: who is in that group alone
as() { group=$1; shift; setpriv --reuid nobody --regid nogroup --groups "$group" --inh-caps=-all "$@"; }
as dexel timeout 60 dexel cat --frames 1 --quiet || wrong 'the group dexel cannot subscribe'
small_scene # the shipped one keeps the emulated processor busy

has Type notify
has WatchdogUSec 20s
for unit in dexeld.service dexeld.socket dexeld-control.socket; do
  systemctl is-enabled --quiet $unit || wrong "$unit is not enabled"
  systemctl is-active --quiet $unit || wrong "$unit is not active"
done

owned() { [ "$(stat -c '%F %U:%G %a' "$1")" = "$2" ] || wrong "$1: $(stat -c '%F %U:%G %a' "$1")"; }
owned /run/dexeld/mesh.sock 'socket root:dexel 660'
owned /run/dexeld/control.sock 'socket root:dexel-admin 660'
owned /var/lib/dexeld 'directory dexeld:dexel 750'

pid=$(shown MainPID)
process() { sed -n "s/^$1:[[:space:]]*//p" "/proc/$pid/status"; }
owned "/proc/$pid" 'directory dexeld:dexel 555'
for group in $(process Groups); do getent group "$group" | cut -d: -f1; done | sort >/run/hil/groups
[ "$(tr '\n' ' ' </run/hil/groups)" = 'dexel dexeld dialout video ' ] || wrong "groups: $(cat /run/hil/groups)"
[ "$(process CapEff)$(process CapBnd)" = 00000000000000000000000000000000 ] || wrong 'it has capabilities'
[ "$(process NoNewPrivs)$(process Seccomp)" = 12 ] || wrong 'no filter of system calls'

as dexel-admin dexel status || wrong 'the group dexel-admin cannot ask'
! as dexel dexel status || wrong 'the group dexel can operate'
! as dexel-admin dexel cat --frames 1 --quiet || wrong 'the group dexel-admin can subscribe'
! as nogroup dexel cat --frames 1 --quiet || wrong 'anybody can subscribe'

said=$(systemd-analyze verify --man=no dexeld.service dexeld.socket dexeld-control.socket dexeld-replay@hall.service 2>&1) || wrong "verify: $said"
[ -z "$said" ] || wrong "verify: $said"
systemd-analyze security --no-pager dexeld.service | tail -n 1
systemd-analyze security --threshold=12 dexeld.service >/dev/null || wrong 'more exposed than docs/operations.md says'
said=$(journalctl -q --no-pager -o cat -p warning -u 'dexeld*')
[ -z "$said" ] || wrong "warned of: $said"

meshed
