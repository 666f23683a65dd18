#!/bin/sh
# The systemd units as they are installed: nothing in them is unknown to systemd, and what is left open to a service that was
# taken over stays within bounds (systemd-analyze security, times ten): 12 as shipped, 15 with the network for TCP scanners.
set -eu
. tests/daemon.sh
command -v systemd-analyze >/dev/null || { echo "no systemd-analyze (package systemd)"; exit 77; }
"$B/tests/sanitized" || { echo "a sanitizer's library is not to be installed"; exit 77; }
root=$run/root
wrong() { echo "$1"; exit 1; }
make -s --no-print-directory DESTDIR="$root" prefix=/usr sysconfdir=/etc install
units=$root/usr/lib/systemd/system

grep -q '^ExecStart=/usr/sbin/dexeld -c /etc/dexeld/dexeld.yaml$' "$units/dexeld.service" || wrong "dexeld.service: not these paths"
for unit in "$units"/*; do
  ! grep -n '@[a-z]*@' "$unit" || wrong "$unit: a path was not filled in"
done

# the program is not in /usr here
mkdir "$run/verify"
for unit in dexeld.service dexeld-replay@.service dexeld.socket dexeld-control.socket; do
  sed 's|/usr/sbin/dexeld|/bin/true|' "$units/$unit" >"$run/verify/$unit"
done
cd "$run/verify"
said=$(systemd-analyze verify --man=no ./dexeld.service ./dexeld.socket ./dexeld-control.socket ./dexeld-replay@hall.service 2>&1) ||
  wrong "verify: $said"
[ -z "$said" ] || wrong "verify: $said"
cd - >/dev/null

bound() {
  systemd-analyze security --offline=true --threshold="$2" "$1" >"$run/exposure" || wrong "$1: $(grep -v '✓' "$run/exposure")"
}
bound "$units/dexeld.service" 12
bound "$units/dexeld-replay@.service" 12
mkdir "$units/dexeld.service.d"
cp "$root/usr/share/doc/dexeld/network.conf" "$units/dexeld.service.d"
bound "$units/dexeld.service" 15
