#!/bin/sh
# Fetches Debian's current kernel for the guest, what its modules are built against, the sources of those that
# Debian does not build, and udev; installs nothing. Again only when this file has changed, or $B/hil/kernel
# has been removed. In it:
#   version    the kernel's release ("6.1.0-57-amd64")
#   vmlinux    uncompressed, which QEMU enters through PVH: a third of the time of a bzImage
#   tree/      lib/modules of the package
#   headers/   usr/src and usr/lib of the headers' packages
#   source/    single files of linux-source;  loopback/: v4l2loopback-dkms;  udev/: the package
set -eu
B=${B:-build}
[ -z "$(find "$B/hil/kernel/version" -newer tests/hil/get_kernel.sh 2>/dev/null)" ] || exit 0

kernel=$B/hil/kernel.new
rm -rf "$kernel"
mkdir -p "$kernel/debs"

# depends PACKAGE: what it depends on
depends() { apt-cache depends "$1" 2>/dev/null | sed -n 's/^ *Depends: //p'; }

find_packages() {
  image=$(depends linux-image-amd64 | grep -m 1 '^linux-image-')
  release=${image#linux-image-}
  series=$(echo "$release" | cut -d. -f1,2)
  [ -n "$series" ] || return 1
  packages="$image linux-headers-$release $(depends "linux-headers-$release" | grep '^linux-')
    linux-source-$series v4l2loopback-dkms udev"
}

download() {
  find_packages || return 1
  # shellcheck disable=SC2086 # lists of words
  (cd "$kernel/debs" && apt-get download $packages >/dev/null 2>../download.log)
}

update() {
  sudo=
  [ "$(id -u)" = 0 ] || sudo=sudo
  $sudo apt-get update >/dev/null
}

# the payload of a bzImage, by the boot protocol: where it begins and ends stands in the header
vmlinux_of() {
  number() { od -An -t "u$3" -j "$2" -N "$3" "$1" | tr -d ' '; }
  begin=$((($(number "$1" 497 1) + 1) * 512 + $(number "$1" 584 4)))
  # its last four bytes are the size unpacked
  payload_len=$(($(number "$1" 588 4) - 4))
  tail -c "+$((begin + 1))" "$1" | head -c "$payload_len" | xz -dc
}

download || { update && download; } || { tail -n 3 "$kernel/download.log" >&2; exit 1; }
echo "hil: kernel $release"

deb() { echo "$kernel/debs/$1"_*.deb; }
mkdir -p "$kernel/tree" "$kernel/source"
dpkg-deb --fsys-tarfile "$(deb "$image")" | tar -x -C "$kernel/tree" --exclude='*/drivers/gpu' \
  --exclude='*/drivers/net' --exclude='*/drivers/scsi' --exclude='*/drivers/iio' --exclude='*/sound' \
  --exclude='*/kernel/net' --exclude='./usr'
vmlinux_of "$kernel/tree/boot/vmlinuz-$release" >"$kernel/vmlinux"
rm -r "$kernel/tree/boot"
for d in "$kernel"/debs/linux-headers-* "$kernel"/debs/linux-kbuild-* "$kernel"/debs/linux-compiler-*; do
  dpkg-deb -x "$d" "$kernel/headers"
done
dpkg-deb -x "$(deb v4l2loopback-dkms)" "$kernel/loopback"
dpkg-deb -x "$(deb udev)" "$kernel/udev"
dpkg-deb --fsys-tarfile "$(deb "linux-source-$series")" | tar -xO "./usr/src/linux-source-$series.tar.xz" |
  xz -dc -T 0 | tar -x -C "$kernel/source" --strip-components=1 --wildcards \
    '*/drivers/gpio/gpio-sim.c' '*/drivers/gpio/gpiolib.h' '*/kernel/irq/irq_sim.c'
rm -r "$kernel/debs" "$kernel/download.log"
echo "$release" >"$kernel/version"
rm -rf "$B/hil/kernel"
mv "$kernel" "$B/hil/kernel"
