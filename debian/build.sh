#!/bin/sh
# Builds the packages in $B/deb, from a copy of the files that git knows: dpkg-buildpackage writes beside its tree.
set -eu
cd "$(dirname "$0")/.."
out=${B:-build}/deb
command -v dh >/dev/null && command -v dh_python3 >/dev/null && command -v dpkg-buildpackage >/dev/null || {
  echo "deb: installing debhelper dh-python fakeroot"
  sudo=
  [ "$(id -u)" = 0 ] || sudo=sudo
  $sudo apt-get install -y --no-install-recommends debhelper dh-python fakeroot dpkg-dev >/dev/null
}
rm -rf "$out"
mkdir -p "$out/dexeld"
git ls-files -z | tar -c --null -T - | tar -x -C "$out/dexeld"
(cd "$out/dexeld" && dpkg-buildpackage -b -us -uc)
rm -r "$out/dexeld"
ls "$out"/*.deb
