#!/bin/sh
# Boots the guest with Debian's systemd, where the packages are installed and the service is run by its units; exit 0 when all
# passed.
#   tests/hil/service/service_guest.sh [TEST...]   all of tests/hil/service, or the installation and those named
#   tests/hil/service/service_guest.sh --shell     a shell in it instead, on this terminal (Ctrl-A X ends it)
# First serial port: the console, $B/hil/service/console.log. Second: results.
set -eu
B=${B:-build}
hil=$B/hil
out=$hil/service
. tests/hil/boot.sh

what=
[ $# = 0 ] || what="hil_tests=$(echo "10_install $*" | tr ' ' ,)"
results=stdio
if [ "${1:-}" = --shell ]; then what=hil_shell results=mon:stdio; fi

guest() {
  qemu "tsc_early_khz=$("$hil/bin/tsc_khz") systemd.show_status=0 $what ${HIL_ARGS:-}" -smp 2 -m 768 -initrd "$out/boot.cpio" \
    -drive "file=$out/root.ext4,if=virtio,format=raw,snapshot=on" \
    -drive "file=$out/disk.ext4,if=virtio,format=raw,readonly=on" \
    -serial "file:$out/console.log" -serial "$results"
}

if [ "$what" = hil_shell ]; then guest; exit; fi
guest </dev/null | show "$out"
verdict "$out"
