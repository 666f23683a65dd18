#!/bin/sh
# The kernel against the oracle, and instruction sets against each other, on 10^8 random cells, and the invariants on large scenes.
set -eu
for t in rules any scenes garbage updates normals threads seam; do
  DEXEL_LONG=1 "${B:-build}/tests/test_terrain_$t"
done
DEXEL_LONG=1 "${B:-build}/tests/test_simd"
