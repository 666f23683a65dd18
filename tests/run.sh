#!/bin/sh
# Runs the tests of a build folder ($B) and ends with "N passed, N failed[, N skipped]".
#   tests/run.sh check|unit|system|tree|long
# A test is a program or script; exit 0 passed, 77 skipped, anything else failed (its output is shown).
set -u
B=${B:-build}
export B
log=$B/test-logs
mkdir -p "$log"
passed=0 failed=0 skipped=0

run() {
  name=$(basename "$1")
  name=${name%.sh}
  if [ -x "$1" ] && [ "${1%.sh}" = "$1" ]; then timeout 600 "$1" >"$log/$name.log" 2>&1
  else timeout 600 sh "$1" >"$log/$name.log" 2>&1; fi
  case $? in
    0) passed=$((passed + 1)); echo "pass  $name" ;;
    77) skipped=$((skipped + 1)); echo "skip  $name: $(tail -n 1 "$log/$name.log")" ;;
    *) failed=$((failed + 1)); echo "FAIL  $name"; tail -n 40 "$log/$name.log" | sed 's/^/      /' ;;
  esac
}

each() { for t in "$@"; do [ -e "$t" ] && run "$t"; done; }

case ${1:-check} in
  unit) for t in tests/unit/test_*.c; do run "$B/tests/$(basename "$t" .c)"; done ;;
  system) each tests/replay/*.sh tests/system/*.sh ;;
  tree) each tests/tree/*.sh ;;
  long) each tests/long/*.sh ;;
  check)
    each tests/tree/*.sh
    for t in tests/unit/test_*.c; do run "$B/tests/$(basename "$t" .c)"; done
    each tests/replay/*.sh tests/system/*.sh ;;
  *) echo "tests/run.sh: unknown tier '$1'" >&2; exit 2 ;;
esac

line="$passed passed, $failed failed"
[ "$skipped" = 0 ] || line="$line, $skipped skipped"
echo "$line"
[ "$failed" = 0 ]
