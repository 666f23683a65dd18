#!/bin/sh
# Debian's own userland for the guest with systemd, as a disk: $B/hil/service/root.ext4, and boot.cpio, which mounts it. Installed by
# apt into a folder, with what our packages depend on; again when that, the kernel or this file has changed. Needs root, and
# takes it by sudo. Exit 3: the packages cannot be had.
set -eu
B=${B:-build}
hil=$B/hil
kernel=$hil/kernel
out=$hil/service
. tests/hil/packing.sh

# what tests load by name, and what systemd does
modules='vivid dummy_hcd libcomposite usb_f_acm cdc-acm gpio-sim autofs4 configfs'
disk_modules='virtio_pci virtio_blk ext4'
# of a machine that stays: nothing here waits for them
masked='apt-daily.timer apt-daily-upgrade.timer dpkg-db-backup.timer e2scrub_all.timer fstrim.timer getty@tty1.service
  serial-getty@ttyS0.service systemd-hwdb-update.service ldconfig.service systemd-journal-catalog-update.service
  systemd-random-seed.service systemd-update-utmp.service systemd-update-utmp-runlevel.service'

# what our packages depend on, the first of alternatives, without our own
depends() {
  for d in "$out"/debs/*.deb; do dpkg-deb -f "$d" Pre-Depends Depends; done | sed 's/^[A-Za-z-]*: //' | tr , '\n' |
    sed 's/|.*//; s/(.*//; s/ //g; /^$/d; /^libdexel/d' | sort -u | tr '\n' ' '
}
packages="systemd systemd-sysv dbus udev kmod $(depends)"
key="$release $packages $(cat tests/hil/service/rootfs.sh tests/hil/service/boot_init tests/hil/packing.sh "$hil/modules.stamp" | cksum)"
[ "$(cat "$out/root.key" 2>/dev/null)" != "$key" ] || exit 0
[ "$(id -u)" = 0 ] || exec sudo B="$B" sh "$0"

suite=$(. /etc/os-release && echo "$VERSION_CODENAME")
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

# shellcheck disable=SC2016 # apt's words
apt-get indextargets --format 'deb $(REPO_URI) $(RELEASE) $(COMPONENT) $(ORIGIN)' 'Created-By: Packages' |
  sed -n 's/ Debian$//p' | sort -u >"$out/sources.list"
mmdebstrap --variant=essential --include="$(echo $packages | tr ' ' ,)" --aptopt='Acquire::Languages "none"' \
  "$suite" "$root" "$out/sources.list" >"$out/rootfs.log" 2>&1 || { tail -n 5 "$out/rootfs.log" >&2; exit 3; }
rm -rf "$root"/var/cache/apt/* "$root"/var/lib/apt/lists/* "$root"/usr/share/locale/*

modules_into "$root" $modules
units=$root/etc/systemd/system
for unit in $masked; do ln -sf /dev/null "$units/$unit"; done
cat >"$units/hil-tests.service" <<'UNIT'
[Unit]
Description=The tests
After=basic.target dbus.socket
[Service]
Type=oneshot
ExecStart=/bin/sh /hil/tests/hil/guest_main.sh
[Install]
WantedBy=multi-user.target
UNIT
mkdir -p "$units/multi-user.target.wants" "$root/hil"
ln -s ../hil-tests.service "$units/multi-user.target.wants"
echo hil >"$root/etc/hostname"
: >"$root/etc/fstab"
echo 8d3f0c1e2b4a4f0d9c8b7a6958473625 >"$root/etc/machine-id"
rm -f "$out/root.ext4"
mkfs.ext4 -q -O ^has_journal -d "$root" "$out/root.ext4" 800M
chmod 644 "$out/root.ext4"

boot=$out/boot
rm -rf "$boot"
mkdir -p "$boot/bin" "$boot/proc" "$boot/dev" "$boot/root" "$boot/modules"
cp "$(command -v busybox)" "$boot/bin/busybox"
install -m 755 tests/hil/service/boot_init "$boot/init"
files_of $disk_modules | while read -r file; do
  cp "$file" "$boot/modules"
  echo "${file##*/}" >>"$boot/modules/list"
done
archive "$boot" "$out/boot.cpio"
echo "$key" >"$out/root.key"
