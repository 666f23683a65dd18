#!/bin/sh
# The kernel on another kind of processor: core and its tests against the oracle, compiled for arm64 (whose generic
# loops are NEON) and run by qemu. Installs compiler and emulator when they are not there.
set -eu
B=${B:-build}
cc=aarch64-linux-gnu-gcc
if ! command -v $cc >/dev/null || ! command -v qemu-aarch64 >/dev/null; then
  sudo=
  [ "$(id -u)" = 0 ] || sudo=sudo
  DEBIAN_FRONTEND=noninteractive $sudo apt-get install -y --no-install-recommends \
    gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user >/dev/null 2>&1 || { echo "no $cc or qemu-aarch64"; exit 77; }
fi
out=$B/arm64
mkdir -p "$out"
# No arm64 packages: cmocka.h is the one beside, libpthread and libm come with the compiler.
flags="-std=gnu17 -O3 -fno-ivopts -ffp-contract=off -fno-trapping-math -fno-math-errno -D_GNU_SOURCE -I. -Itests/unit
  -Itests/long/arm64 -pthread"
sources=$(ls core/base/*.c core/rows/*.c core/grid/*.c core/wire/*.c drivers/synth/*.c |
  grep -v '/rows_avx\|/synth.c')
objects=
for f in $sources; do
  o=$out/$(basename "$f" .c).o
  # shellcheck disable=SC2086 # lists of words
  $cc $flags -c "$f" -o "$o"
  objects="$objects $o"
done
for t in ${TESTS:-terrain_rules terrain_any terrain_scenes terrain_updates terrain_seam simd fit_ranges estimator publish_sets chunk chunk_delta digests lod lod_updates}; do
  # shellcheck disable=SC2086
  $cc $flags -static "tests/unit/test_$t.c" $objects -lm -o "$out/test_$t"
  echo "arm64: $t"
  qemu-aarch64 "$out/test_$t"
done
