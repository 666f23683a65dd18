#!/bin/sh
# make hil: the driver tests in a guest with Debian's kernel, then the packages in one with Debian's systemd besides; ends with
# "N passed, N failed[, N skipped]", the sums of both. What cannot be fetched or emulated here skips them, and says
# why. $MAKE builds the programs.
set -eu
B=${B:-build}
export B HIL_PART=yes
cd "$(dirname "$0")/../.."
passed=0 failed=0 skipped=0

end() {
  line="$passed passed, $failed failed"
  [ $skipped = 0 ] || line="$line, $skipped skipped"
  echo "$line"
  [ $failed = 0 ]
  exit
}

skip() { echo "skip  hil: $1"; skipped=$((skipped + 1)); end; }

# what fails for a reason of its own, not of the outside, is a failure
failed() { echo "FAIL  hil: $1"; failed=$((failed + 1)); end; }

# add FOLDER: what a guest has counted
add() {
  read -r p _ f _ s _ <<COUNTS
$(tail -n 1 "$1/results.log")
COUNTS
  passed=$((passed + p)) failed=$((failed + f)) skipped=$((skipped + ${s:-0}))
}

mkdir -p "$B/hil"
[ "$(uname -m)" = x86_64 ] || skip "the guest is x86_64, this machine is $(uname -m)"
command -v apt-get >/dev/null || skip 'no apt-get to fetch QEMU and a kernel with'
sh tests/hil/deps.sh || skip "cannot install $(sed -n "s/^packages='\(.*\)'/\1/p" tests/hil/deps.sh)"
sh tests/hil/get_kernel.sh || skip "cannot fetch Debian's kernel"
sh tests/hil/modules.sh || failed 'the kernel modules do not build'
${MAKE:-make} --no-print-directory all hil-programs || failed 'the programs do not build'
sh tests/hil/initramfs.sh || failed 'the guest cannot be packed'
sh tests/hil/run.sh "$@" || true
add "$B/hil"

[ $# = 0 ] || end
sh tests/hil/deps.sh service || skip "cannot install what makes packages and Debian's root"
sh tests/hil/service/debs.sh || failed 'the packages do not build'
status=0
sh tests/hil/service/rootfs.sh || status=$?
[ $status != 3 ] || skip "cannot fetch Debian's packages for the guest with systemd"
[ $status = 0 ] || failed "Debian's root cannot be made"
sh tests/hil/service/disk.sh || failed 'the second disk cannot be made'
sh tests/hil/service/service_guest.sh || true
add "$B/hil/service"
end
