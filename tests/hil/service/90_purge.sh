# Removed, configuration and recordings stay; purged, nothing is left: no file, user, group, unit or socket.
# limit: 300
set -eu
. tests/hil/devices.sh
. tests/hil/installed.sh

[ ! -s /var/lib/dexeld/hall.mcap ] || systemctl start dexeld-replay@hall.service
dpkg -r dexeld
[ -z "$(systemctl list-units --plain --no-legend --state=active,activating 'dexel*')" ] || wrong 'a unit is active'
[ ! -e /run/dexeld/mesh.sock ] && [ ! -e /usr/sbin/dexeld ] || wrong 'it is not gone'
[ -e $config ] && [ -d /var/lib/dexeld ] || wrong 'a removal took configuration or recordings'
getent passwd dexeld

dpkg -P dexeld dexel-tools libdexel-dev libdexel0
systemctl daemon-reload
everything >/run/hil/after
diff /run/hil/before /run/hil/after || wrong 'something is left'
[ -z "$(systemctl list-units --all --plain --no-legend 'dexel*'; systemctl list-unit-files --no-legend 'dexel*')" ] || wrong 'a unit is left'
