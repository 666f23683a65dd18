#!/bin/sh
# The manual pages are correct mdoc, and name every long option that the programs take.
set -u
command -v mandoc >/dev/null || { echo "no mandoc"; exit 77; }
mandoc -Tlint -W warning docs/*.[1-8] || exit 1

bad=0
names() { # PAGE SOURCE...: options in the sources' tables for getopt_long, and of mesh modes
  page=$1
  shift
  for o in $(sed -nE 's/^ *\{?"([a-z-]+)", ((no|required)_argument|DX_MESH_[A-Z]+),.*/\1/p' "$@"); do
    grep -qE -- "Fl -$o( |$)" "$page" || { echo "$page does not name --$o"; bad=1; }
  done
}
names docs/dexel.1 tools/*.[ch]
names docs/dexeld.8 daemon/*.[ch]
exit $bad
