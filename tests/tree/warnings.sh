#!/bin/sh
# All sources compile without a warning under gcc and clang, with the warnings of the Makefile.
set -u
flags="-std=gnu17 $(sed -n 's/^WARN := //p' Makefile)"
defines='-I. -Iclient -D_GNU_SOURCE -DDEXELD_VERSION="0" -DDEXELD_SYSCONFDIR="/etc"'
packages=$(pkg-config --cflags $(sed -n 's/^PACKAGES := //p' Makefile))
sources=$(git ls-files '*.c')
bad=0
for cc in gcc clang; do
  command -v $cc >/dev/null || { echo "no $cc"; exit 77; }
  # shellcheck disable=SC2086 # lists of words
  $cc $flags $defines $packages -Werror -fsyntax-only $sources || bad=1
done
exit $bad
