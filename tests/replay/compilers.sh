#!/bin/sh
# The golden digests again from programs built by the other compiler, and without optimisation.
set -eu
"${B:-build}/tests/sanitized" || { echo "it builds its own programs, the same in any build"; exit 77; }
for build in 'gcc -O0' 'clang -O0' 'clang -O3'; do
  # shellcheck disable=SC2086 # two words
  set -- $build
  command -v "$1" >/dev/null || { echo "$1 is not there"; exit 77; }
  alt=build/alt/$1$2
  make --no-print-directory -j"$(nproc)" B="$alt" CC="$1" OPT="$2" SAN= "$alt/bin/dexel"
  B=$alt sh tests/replay/scenes.sh
done
