#!/bin/sh
# Installs the Debian packages that building and testing need, when they are not there; says what it does.
set -eu

packages='gcc clang libclang-rt-14-dev clang-format make pkg-config git libsystemd-dev libyaml-dev libjansson-dev
liblzf-dev liblz4-dev libpng-dev libzstd-dev zlib1g-dev libcmocka-dev mandoc
libusb-1.0-0-dev libgpiod-dev libumockdev-dev umockdev libusbredirparser-dev
systemd python3-numpy'

missing=
for p in $packages; do
  dpkg-query -W -f='${Status}' "$p" 2>/dev/null | grep -q 'ok installed' || missing="$missing $p"
done
[ -n "$missing" ] || exit 0

echo "deps: installing$missing"
sudo=
[ "$(id -u)" = 0 ] || sudo=sudo
export DEBIAN_FRONTEND=noninteractive
# shellcheck disable=SC2086 # lists of words
$sudo apt-get install -y --no-install-recommends $missing >/dev/null 2>&1 ||
  { $sudo apt-get update >/dev/null && $sudo apt-get install -y --no-install-recommends $missing; }
