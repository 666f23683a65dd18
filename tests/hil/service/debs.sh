#!/bin/sh
# The packages for the guest, in $B/hil/service/debs: those of `make deb`, again when a file that git knows has changed, and in
# next/ a later version of the service, whose configuration file is another one.
set -eu
B=${B:-build}
out=$B/hil/service/debs

# a file that is gone counts as changed
is_current() {
  [ -e "$out/stamp" ] || return 1
  git ls-files >"$out/files.now"
  cmp -s "$out/files" "$out/files.now" || return 1
  [ -z "$(git ls-files -z | grep -zv -e '^docs/' -e '^tests/' | xargs -0 sh -c 'find "$@" -newer "$0"' "$out/stamp" 2>&1)" ]
}
is_current && exit

rm -rf "$out"
mkdir -p "$out/next"
touch "$out/stamp.new"
DEB_BUILD_OPTIONS=noautodbgsym B=$B sh debian/build.sh >"$out/build.log" 2>&1 || { tail -n 20 "$out/build.log" >&2; exit 1; }
for p in dexeld dexel-tools libdexel0 libdexel-dev; do cp "$B/deb/$p"_*.deb "$out"; done

later=$out/later
dpkg-deb -R "$out"/dexeld_*.deb "$later"
sed -i 's/^Version: .*/&+later/' "$later/DEBIAN/control"
echo '# of a later version' >>"$later/etc/dexeld/dexeld.yaml"
dpkg-deb --root-owner-group -Zgzip -b "$later" "$out/next" >/dev/null
rm -r "$later"
git ls-files >"$out/files"
mv "$out/stamp.new" "$out/stamp"
