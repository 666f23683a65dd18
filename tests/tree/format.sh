#!/bin/sh
# The layout of all tracked C files is what .clang-format says.
set -u
for tool in clang-format-14 clang-format; do
  command -v $tool >/dev/null && break
  tool=
done
[ -n "$tool" ] || { echo "no clang-format"; exit 77; }
git ls-files '*.c' '*.h' | xargs $tool --dry-run -Werror
