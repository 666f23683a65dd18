#!/bin/sh
# All C files under clang-tidy (.clang-tidy) and cppcheck (tests/cppcheck.*), with the Makefile's flags; installs the two.
# Prints what they find, and fails then.
#   lint.sh [FILE...]    these files only
set -eu
B=${B:-build}
out=$B/lint
bad=0
mkdir -p "$out/cppcheck"

if ! command -v clang-tidy >/dev/null || ! command -v cppcheck >/dev/null; then
  sudo=
  [ "$(id -u)" = 0 ] || sudo=sudo
  DEBIAN_FRONTEND=noninteractive $sudo apt-get install -y --no-install-recommends clang-tidy cppcheck >/dev/null
fi

flags=$(make -s --no-print-directory CC=clang lint-flags)
# shellcheck disable=SC2046 # a list of words
[ $# -gt 0 ] || set -- $(make -s --no-print-directory lint-sources)

# One file a process: from its second file on, clang-tidy 14 takes each va_list for one that was not begun.
: >"$out/tidy.log"
tidy() { # FLAGS, files from standard input
  xargs -r -n 1 -P "$(nproc)" sh -c "clang-tidy --quiet \"\$@\" -- $flags $1" sh >>"$out/tidy.log" 2>&1
}
own='^core/base/err\.c$|^core/rows/rows_avx' # what the model is of; rows for instruction sets of their own
unit='^tests/(unit|bench)/'
printf '%s\n' "$@" | { grep -vE "$own|$unit" || :; } | tidy '-include tests/lint_model.h' || bad=1
printf '%s\n' "$@" | { grep -E "$unit" || :; } | tidy '-include tests/lint_model_tests.h' || bad=1
printf '%s\n' "$@" | { grep -E "$own" || :; } | tidy '-march=x86-64-v4 -mavx512vbmi2' || bad=1
grep -vE '^[0-9]+ warnings? (generated|treated as error)' "$out/tidy.log" || :

cppcheck --quiet -j "$(nproc)" --error-exitcode=1 --enable=warning,performance,portability --std=c11 \
  --library=posix --library=tests/cppcheck.cfg --suppressions-list=tests/cppcheck.suppressions \
  --cppcheck-build-dir="$out/cppcheck" -I. -Iclient -D_GNU_SOURCE -DDEXELD_VERSION='"0"' \
  --template='{file}:{line}: {severity}: {message} [{id}]' "$@" || bad=1
exit $bad
