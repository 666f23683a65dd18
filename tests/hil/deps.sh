#!/bin/sh
# Installs the Debian packages that only `make hil` needs, when they are not there; `deps.sh service`: those for the guest with
# systemd. Kernel, headers and udev are not installed: get_kernel.sh unpacks them under the build folder.
set -eu

packages='qemu-system-x86 busybox-static cpio kmod xz-utils'
service_packages='mmdebstrap e2fsprogs debhelper dh-python fakeroot dpkg-dev'
[ "${1:-}" != service ] || packages=$service_packages

missing=
for p in $packages; do
  dpkg-query -W -f='${Status}' "$p" 2>/dev/null | grep -q 'ok installed' || missing="$missing $p"
done
[ -n "$missing" ] || exit 0

echo "hil: installing$missing"
sudo=
[ "$(id -u)" = 0 ] || sudo=sudo
export DEBIAN_FRONTEND=noninteractive
# shellcheck disable=SC2086 # lists of words
$sudo apt-get install -y --no-install-recommends $missing >/dev/null 2>&1 ||
  { $sudo apt-get update >/dev/null && $sudo apt-get install -y --no-install-recommends $missing >/dev/null; }
