#!/bin/sh
# Every fuzz target in turn, under ASan and UBSan, from its seeds and what earlier runs have grown of them, for
# $FUZZ_SECONDS (20: a long test has twenty minutes, tests/run_one.sh) each, or $FUZZ_TOTAL seconds in all; or those that
# are named in $FUZZ_TARGETS ("wire mcap").
# A line for each: runs, and what of the code was reached. Crash, leak, slow input (10 s) and memory (2 GiB) are
# findings: each is told with the file that shows it, and the script fails when all targets have had their turn.
set -u
B=${B:-build}
make --no-print-directory -j"$(nproc)" B="$B" fuzz || exit 1
targets=${FUZZ_TARGETS:-$(for t in tests/fuzz/fuzz_*.c; do basename "$t" .c | sed 's/^fuzz_//'; done)}
# shellcheck disable=SC2086
set -- $targets
[ $# -gt 0 ] || { echo "no fuzz target" >&2; exit 1; }
seconds=${FUZZ_SECONDS:-20}
[ -z "${FUZZ_TOTAL:-}" ] || seconds=$((FUZZ_TOTAL / $# > 0 ? FUZZ_TOTAL / $# : 1))
findings=0
export LC_ALL=C # logs hold bytes of inputs

# The last number behind a word of the log.
number() { grep -ao "$1 *[0-9][0-9]*" "$2" | tail -1 | grep -o '[0-9]*$'; }

# The fuzzer's own exit status is 77 at a crash, which would be a skipped test here.
finding() {
  findings=$((findings + 1))
  tail -40 "$2" >&2
  file=$(sed -n 's/^.*Test unit written to //p' "$2" | tail -1)
  echo "fuzz_$1: FOUND $(sed -n 's/^.*SUMMARY: //p' "$2" | tail -1); input: ${file:-none, see $2}"
}

for name; do
  grown=$B/fuzz/corpus-$name log=$B/fuzz/$name.log words=tests/fuzz/$name.dict
  mkdir -p "$grown"
  [ -e "$words" ] || words=
  if "$B/fuzz/fuzz_$name" -max_total_time="$seconds" -rss_limit_mb=2048 -timeout=10 -print_final_stats=1 \
    ${words:+-dict="$words"} -artifact_prefix="$B/fuzz/$name-" "$grown" "tests/fuzz/corpus/$name" >"$log" 2>&1; then
    echo "fuzz_$name: $(number stat::number_of_executed_units: "$log") runs, cov $(number cov: "$log")," \
      "ft $(number ft: "$log"), slowest $(number stat::slowest_unit_time_sec: "$log") s"
  else
    finding "$name" "$log"
  fi
done
[ "$findings" = 0 ] || echo "$findings of $# targets have findings"
[ "$findings" = 0 ]
