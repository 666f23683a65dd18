#!/bin/sh
# What is tested in the guest with systemd, as its second disk: the packages, the tests, and programs that play their parts.
set -eu
B=${B:-build}
out=$B/hil/service
PATH=$PATH:/sbin:/usr/sbin
root=$out/disk
rm -rf "$root"
mkdir -p "$root/bin" "$root/tests/hil/service"
cp -r "$out/debs" "$root"
for p in $(find "$B/hil/bin" -type f ! -name 'redir_*') "$B/tests/scip_sim" "$B/tests/dexeld_faults"; do strip -o "$root/bin/${p##*/}" "$p"; done
cp tests/hil/runner.sh tests/hil/devices.sh tests/hil/service/installed.sh tests/hil/service/guest_main.sh "$root/tests/hil"
cp tests/hil/service/[0-9]*.sh "$root/tests/hil/service"
rm -f "$out/disk.ext4"
mkfs.ext4 -q -O ^has_journal -d "$root" "$out/disk.ext4" 96M
rm -r "$root"
