# What a service that was taken over could do: a probe runs in the service's place, within its unit's sandbox; first as the
# service's user, then as root, whom no file's mode keeps out. Outside of it, the probe can do much more.
# limit: 300
set -eu
. tests/hil/devices.sh
. tests/hil/installed.sh

load_vivid
load_gpio_sim
touch /tmp/hil-marker /root/hil-marker
mkdir -p /run/hil/probe
chmod 755 /run/hil

# probed USER: the lines of the probe as USER
probed() {
  rm -f /var/lib/dexeld/probed
  drop_in <<CONF
Type=oneshot
WatchdogSec=0
Restart=no
User=$1
ExecStart=
ExecStart=/hil/bin/sandbox_probe /var/lib/dexeld/probed
CONF
  systemctl restart dexeld.service
  cat /var/lib/dexeld/probed
}

# standard pseudo devices, and what the driver of each kind serves
cat >/run/hil/may <<LIST
device /dev/full
device /dev/$chip
device /dev/null
device /dev/ptmx
device /dev/random
device /dev/tty
device /dev/urandom
device $video
device /dev/zero
write /run/dexeld-metrics
write /tmp
write /var/lib/dexeld
write /var/tmp
read /etc/dexeld/dexeld.yaml
socket netlink
socket unix
LIST
sandbox_probe /run/hil/outside
wc -l </run/hil/outside
for what in 'device /dev/vda' 'device /dev/kmsg' 'device /dev/mem' 'write /etc' 'read /tmp/hil-marker' 'socket inet' 'call mount' 'call user namespace'; do
  grep -qx "$what" /run/hil/outside || wrong "outside of the sandbox: not '$what'"
done
probed dexeld >/run/hil/probed
cat /run/hil/probed
sort /run/hil/may >/run/hil/may.sorted
sort /run/hil/probed | diff /run/hil/may.sorted - || wrong 'the sandbox is another one'
probed root | grep -v -e '^write' -e '^read' | sort >/run/hil/probed.sorted
cat /run/hil/probed.sorted
# ProtectClock lets who may read the clock's node do so
{ grep -v -e '^write' -e '^read' /run/hil/may.sorted; echo 'device /dev/rtc0'; } | sort | diff - /run/hil/probed.sorted || wrong 'for root, the sandbox is another one'
rm /var/lib/dexeld/probed /tmp/hil-marker /root/hil-marker
