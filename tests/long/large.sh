#!/bin/sh
# Forty million dexels through every stage: no overflow, no allocation a frame.
set -eu
"${B:-build}/bin/dexel" bench --size 10000x4000 --rounds 3 --json | tee "${B:-build}/large.json"
grep -q '"allocations_per_frame": 0.0' "${B:-build}/large.json"
