#!/bin/sh
# What each driver of a device costs at its full rate: `make bench-drivers`. The programs say what of a real device
# is not in it (tests/bench/bench_*.c).
#   tests/bench/drivers.sh [--markdown]
set -eu
B=${B:-build}
seconds=${SECONDS_EACH:-5}
cat <<'TEXT'
| driver | rate, Hz | frames | lost | CPU, % of one | a frame, µs | p50, µs | p99, µs | most, µs |
|:---|---:|---:|---:|---:|---:|---:|---:|---:|
TEXT
for bench in scip kinect v4l2; do "$B/bench/bench_$bench" "$seconds"; done
