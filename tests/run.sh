#!/bin/sh
# Runs the tests of a build folder ($B), as many at a time as there are processors ($JOBS), and ends with
# "N passed, N failed[, N skipped]".
#   tests/run.sh check|unit|system|tree|long, or these TEST...
# A test is a program or script; exit 0 passed, 77 skipped, anything else failed (its output is shown).
set -u
B=${B:-build}
export B
log=$B/test-logs
mkdir -p "$log"

trees() { ls tests/tree/*.sh; }
units() { for t in tests/unit/test_*.c; do echo "$B/tests/$(basename "$t" .c)"; done; }
# those that build something are the longest: first
systems() { ls tests/replay/compilers.sh tests/system/install.sh; ls tests/replay/*.sh tests/system/*.sh | grep -v -e /compilers -e /install; }

case ${1:-check} in
  unit) units ;;
  system) systems ;;
  tree) trees ;;
  long) ls tests/long/*.sh ;;
  check) trees; systems; units ;;
  these) shift && printf '%s\n' "$@" ;;
  *) echo "tests/run.sh: unknown tier '$1'" >&2; exit 2 ;;
esac >"$log/tests"

xargs -n 1 -P "${JOBS:-$(nproc)}" sh tests/run_one.sh "$log" <"$log/tests" | tee "$log/results"

count() { grep -c "^$1 " "$log/results"; }
passed=$(count pass) skipped=$(count skip)
# a test that told nothing has failed as well
failed=$(($(grep -c . "$log/tests") - passed - skipped))
line="$passed passed, $failed failed"
[ "$skipped" = 0 ] || line="$line, $skipped skipped"
echo "$line"
[ "$failed" = 0 ]
