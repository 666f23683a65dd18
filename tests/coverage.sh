#!/bin/sh
# Shares of lines that were run, room by room, from what a build with --coverage has left in $B; installs gcovr. What was not run,
# file by file, is in $B/coverage.txt.
#   coverage.sh [LEAST]    percent, of the first rooms; 90. The others are shown beside.
set -eu
least=${1:-90}
command -v gcovr >/dev/null || {
  sudo=
  [ "$(id -u)" = 0 ] || sudo=sudo
  DEBIAN_FRONTEND=noninteractive $sudo apt-get install -y --no-install-recommends gcovr >/dev/null
}

# Loops for instructions that this processor has not, or of another kind of processor, cannot run here.
lacks() { for flag; do grep -qw "$flag" /proc/cpuinfo 2>/dev/null || return 0; done; return 1; }
absent=
lacks avx2 && absent='--exclude core/rows/rows_avx2\.c'
lacks avx512f avx512bw avx512dq avx512vl avx512cd avx512_vbmi2 && absent="$absent --exclude core/rows/rows_avx512\\.c"

# shellcheck disable=SC2086 # words
gcovr --root . --object-directory "$B/obj" --filter core/ --filter daemon/ --filter client/ --filter drivers/ --filter tools/ $absent \
  --json "$B/coverage.json" "$B/obj" 2>"$B/gcovr.log"
gcovr --root . --add-tracefile "$B/coverage.json" --csv "$B/coverage.csv" --txt "$B/coverage.txt" 2>>"$B/gcovr.log"

awk -F, -v least="$least" -v rooms='core/base core/grid core/rows core/cloud core/wire daemon' '
  FNR == 1 {next}
  {
    room = $1
    if (room ~ /^core\//) sub(/\/[^\/]*$/, "", room); else sub(/\/.*/, "", room)
    lines[room] += $2
    run[room] += $3
  }
  function show(room, note) {
    share = lines[room] ? 100 * run[room] / lines[room] : 0
    printf "%-11s %5.1f %%  %5d of %5d lines%s\n", room, share, run[room], lines[room], note
    return share
  }
  END {
    n = split(rooms, barred, " ")
    for (k = 1; k <= n; k++)
      if (show(barred[k], "") < least) bad = bad " " barred[k]
    n = split("client drivers tools", others, " ")
    for (k = 1; k <= n; k++) show(others[k], ", for information")
    if (bad) print "below " least " %:" bad
    exit bad != ""
  }' "$B/coverage.csv"
