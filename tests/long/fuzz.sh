#!/bin/sh
# Every fuzz target for $FUZZ_SECONDS (600) under ASan and UBSan, from its seeds.
set -eu
B=${B:-build}
make --no-print-directory B="$B" fuzz
for target in "$B"/fuzz/fuzz_*; do
  name=${target##*/fuzz_}
  grown=$B/fuzz/corpus-$name
  mkdir -p "$grown"
  "$target" -max_total_time="${FUZZ_SECONDS:-600}" -max_len=4096 -rss_limit_mb=2048 -timeout=20 \
    -artifact_prefix="$B/fuzz/$name-" -print_final_stats=1 "$grown" "tests/fuzz/corpus/$name"
done
