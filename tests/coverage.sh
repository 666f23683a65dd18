#!/bin/sh
# Shares of lines that were run, room by room, from what a build with --coverage has left in $B; installs gcovr.
#   coverage.sh [LEAST]    percent; 90
set -eu
least=${1:-90}
command -v gcovr >/dev/null || {
  sudo=
  [ "$(id -u)" = 0 ] || sudo=sudo
  DEBIAN_FRONTEND=noninteractive $sudo apt-get install -y --no-install-recommends gcovr >/dev/null
}
bad=0
for room in core/base core/grid core/rows core/cloud core/wire daemon; do
  gcovr --root . --object-directory "$B" --filter "$room/" --print-summary --output "$B/$(echo "$room" | tr / -).txt" \
    --fail-under-line "$least" >"$B/summary" 2>"$B/gcovr.log" || bad=1
  printf '%-12s %s\n' "$room" "$(sed -n 's/^lines: //p' "$B/summary")"
done
exit $bad
