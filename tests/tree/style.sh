#!/bin/sh
# Rules of style that a machine can check (CONTRIBUTING.md): no file over 500 lines, no typedef of a struct,
# no tab in C, no path of one machine. Functions over 60 lines are reported.
set -u
bad=0
breach() { echo "$1"; bad=1; }
c=$(git ls-files '*.c' '*.h')

hits=$(wc -l $c | awk '$2 != "total" && $1 > 500 {print $2 ": " $1 " lines, expected at most 500"}')
[ -z "$hits" ] || breach "$hits"
hits=$(grep -nE '^ *typedef +(struct|union|enum)' $c)
[ -z "$hits" ] || breach "typedef of a struct: $hits"
hits=$(grep -nP '\t' $c)
[ -z "$hits" ] || breach "tab: $hits"
# The one-letter classes keep this line from finding itself.
hits=$(git grep -nIE '(^|[^a-zA-Z0-9_.})])/([w]ork|[f]arm|[h]ome)/')
[ -z "$hits" ] || breach "path of one machine: $hits"

awk '
  FNR == 1 {start = 0}
  /^{/ {start = FNR}
  /^}/ && start {if (FNR - start - 1 > 60) print FILENAME ":" start ": function of " FNR - start - 1 " lines"; start = 0}
' $c
exit $bad
