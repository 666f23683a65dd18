#!/bin/sh
# make hil: the driver tests in a guest with Debian's kernel; ends with "N passed, N failed[, N skipped]". What cannot
# be fetched or emulated here skips them all, and says why. $MAKE builds the programs.
set -eu
B=${B:-build}
export B
cd "$(dirname "$0")/../.."

skip() {
  echo "skip  hil: $1"
  echo '0 passed, 0 failed, 1 skipped'
  exit 0
}

# what fails from here to `run.sh` for a reason of its own, not of the outside, is a failure
failed() {
  echo "FAIL  hil: $1"
  echo '0 passed, 1 failed'
  exit 1
}

mkdir -p "$B/hil"
[ "$(uname -m)" = x86_64 ] || skip "the guest is x86_64, this machine is $(uname -m)"
command -v apt-get >/dev/null || skip 'no apt-get to fetch QEMU and a kernel with'
sh tests/hil/deps.sh || skip "cannot install $(sed -n "s/^packages='\(.*\)'/\1/p" tests/hil/deps.sh)"
sh tests/hil/get_kernel.sh || skip "cannot fetch Debian's kernel"
sh tests/hil/modules.sh || failed 'the kernel modules do not build'
${MAKE:-make} --no-print-directory all hil-programs || failed 'the programs do not build'
sh tests/hil/initramfs.sh || failed 'the guest cannot be packed'
exec sh tests/hil/run.sh "$@"
