#!/bin/sh
# Packs the guest: base.cpio (busybox, kernel modules, udev; when those have changed) and, each time, what is
# tested (our programs with their libraries, the tests, digests of the host). Not compressed: the
# emulated processor would spend longer unpacking than reading.
set -eu
B=${B:-build}
hil=$B/hil
kernel=$hil/kernel
. tests/hil/packing.sh

# what tests load by name, with what it depends on
modules='vivid v4l2loopback uvcvideo dummy_hcd libcomposite usb_f_fs usb_f_acm cdc-acm gpio-sim xhci-pci usbmon'

# with_libraries ROOT PROGRAM...: into ROOT/bin, and all shared libraries to where they are sought
with_libraries() {
  root=$1
  shift
  mkdir -p "$root/bin"
  cp "$@" "$root/bin"
  for p in "$@"; do ldd "$p"; done | grep -oE '/[^ ]+\.so[^ ]*' | sort -u | while read -r library; do
    mkdir -p "$root${library%/*}"
    cp -L "$library" "$root$library"
  done
}

pack_base() {
  root=$hil/root
  rm -rf "$root"
  for d in proc sys dev run tmp lib/modules lib/systemd; do mkdir -p "$root/$d"; done
  with_libraries "$root" "$(find "$kernel/udev" -name udevadm -path '*/bin/*')"
  cp "$(command -v busybox)" "$root/bin/busybox"
  ln -s /bin/udevadm "$root/lib/systemd/systemd-udevd"
  # shellcheck disable=SC2086 # a list of words
  modules_into "$root" $modules
  archive "$root" "$hil/base.cpio"
}

pack_tests() {
  root=$hil/root-tests
  rm -rf "$root"
  mkdir -p "$root/expected" "$root/tests/hil/guest"
  # shellcheck disable=SC2046 # a list of programs
  with_libraries "$root" "$B/bin/dexeld" "$B/bin/dexel" "$B/tests/scip_sim" $(find "$hil/bin" -type f ! -name 'redir_*')
  install -m 755 tests/hil/init "$root/init"
  cp tests/daemon.sh "$root/tests"
  cp tests/hil/runner.sh tests/hil/devices.sh tests/hil/replug.sh "$root/tests/hil"
  cp tests/hil/guest/*.sh "$root/tests/hil/guest"
  sh tests/hil/expected.sh "$root/expected"
  archive "$root" "$hil/tests.cpio"
}

[ -n "$(find "$hil/base.cpio" -newer "$hil/modules.stamp" -newer tests/hil/initramfs.sh -newer tests/hil/packing.sh 2>/dev/null)" ] || pack_base
pack_tests
cat "$hil/base.cpio" "$hil/tests.cpio" >"$hil/guest.cpio"
