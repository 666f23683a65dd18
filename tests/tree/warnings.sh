#!/bin/sh
# All sources compile without a warning under gcc and clang, with the warnings of the Makefile.
set -u
flags="-std=gnu17 $(sed -n 's/^WARN := //p' Makefile)"
defines='-I. -Iclient -D_GNU_SOURCE -DDEXELD_VERSION="0" -DDEXELD_SYSCONFDIR="/etc"'
packages=$(pkg-config --cflags $(sed -n 's/^PACKAGES := //p' Makefile) umockdev-1.0)
sets='core/rows/rows_avx2.c core/rows/rows_avx512.c' # for their own instruction sets, x86-64 only
case $(pkg-config --modversion libgpiod) in # the back end of the other libgpiod cannot be compiled here
  1.*) others=drivers/gpio/gpio_libgpiod2.c ;;
  *) others=drivers/gpio/gpio_libgpiod1.c ;;
esac
sources=$(git ls-files '*.c' | grep -vxF "$(echo $sets $others | tr ' ' '\n')")
bad=0
for cc in gcc clang; do
  command -v $cc >/dev/null || { echo "no $cc"; exit 77; }
  # shellcheck disable=SC2086 # lists of words
  $cc $flags $defines $packages -Werror -fsyntax-only $sources || bad=1
  case $($cc -dumpmachine) in
    x86_64*) $cc $flags $defines -march=x86-64-v4 -Werror -fsyntax-only $sets || bad=1 ;;
  esac
done
exit $bad
