# Stopped, the service is started by who subscribes, who then gets the mesh; by the socket for operators as well. Its sockets go
# with their units, and come with the service.
# limit: 300
set -eu
. tests/hil/devices.sh
. tests/hil/installed.sh

inode=$(stat -c %i $run/mesh.sock)
systemctl stop dexeld.service
has ActiveState inactive
has Result success
has ActiveState active dexeld.socket
meshed
has ActiveState active
triggers=$(systemctl show -P TriggeredBy dexeld.service | tr ' ' '\n' | sort | tr '\n' ' ')
[ "$triggers" = 'dexeld-control.socket dexeld.socket ' ] || wrong "triggered by $triggers"
[ "$(stat -c %i $run/mesh.sock)" = "$inode" ] || wrong 'the socket is another one'

systemctl stop dexeld.service
dexel status || true # it waits for five seconds, in which a busy host has not started a service
await 60 is ActiveState active
dexel status

systemctl stop dexeld.socket dexeld-control.socket
has ActiveState inactive
[ ! -e $run/mesh.sock ] && [ ! -e $run/control.sock ] || wrong 'a socket is left'
systemctl start dexeld.service
has ActiveState active dexeld.socket
has ActiveState active dexeld-control.socket
meshed
