#!/bin/sh
# The names that libdexel exports are those that its package promises, and the package's version is the Makefile's.
set -eu
B=${B:-build}
# a sanitizer exports names of its own
"$B/tests/sanitized" || { echo "a sanitizer's library is not the one that is shipped"; exit 77; }
nm -D --defined-only "$B/lib/libdexel.so" | awk '{ print $3 }' | sort >"$B/exports"
sed -n 's/^ \([a-z_0-9]*\)@Base .*/\1/p' debian/libdexel0.symbols | sort >"$B/promised"
diff "$B/promised" "$B/exports" || { echo "libdexel: < promised in debian/libdexel0.symbols, > exported"; exit 1; }
[ -s "$B/exports" ]

made=$(sed -n 's/^VERSION := //p' Makefile)
packaged=$(sed -n '1s/.*(\(.*\)).*/\1/p' debian/changelog)
[ "$made" = "$packaged" ] || { echo "Makefile: version $made, debian/changelog: $packaged"; exit 1; }
