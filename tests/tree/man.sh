#!/bin/sh
# The manual pages are correct mdoc, for mandoc and for groff; there is one for each program and subcommand; they name every long
# option that the programs take, those of a subcommand on its own page; and pages that they refer to are there.
set -u
command -v mandoc >/dev/null || { echo "no mandoc"; exit 77; }
mandoc -Tlint -W warning docs/*.[1-8] || exit 1

bad=0
breach() { echo "$1"; bad=1; }
if command -v man >/dev/null && command -v groff >/dev/null; then
  for page in docs/*.[1-8]; do
    said=$(LC_ALL=C.UTF-8 MANROFFSEQ='' MANWIDTH=80 man --warnings -E UTF-8 -l -Tutf8 -Z "$page" 2>&1 >/dev/null)
    [ -z "$said" ] || breach "man --warnings: $page: $said"
  done
fi

names() { # 'PAGE...' SOURCE...: options in the sources' tables for getopt_long, and of mesh modes
  pages=$1
  shift
  for o in $(sed -nE 's/^ *\{?"([a-z-]+)", ((no|required)_argument|DX_MESH_[A-Z]+),.*/\1/p' "$@"); do
    # shellcheck disable=SC2086 # several pages
    grep -qE -- "Fl -$o( |$)" $pages || breach "$pages: --$o is not named"
  done
}
names "$(echo docs/dexel*.1)" tools/*.[ch]
names docs/dexeld.8 daemon/*.[ch]

for command in $(sed -nE 's/^ *\{"([a-z-]+)", "dexel [a-z-]+",.*/\1/p' tools/main.c); do
  page=docs/dexel-$command.1
  [ -f "$page" ] || { breach "dexel $command has no page"; continue; }
  grep -qx "\.Nm dexel-$command" "$page" || breach "$page: another name"
  grep -q "^\.It Xr dexel-$command 1" docs/dexel.1 || breach "docs/dexel.1 does not refer to $page"
  # --help and --version are of all commands; the terrain options have their section
  for o in $(sed -nE 's/^ *\{?"([a-z-]+)", (no|required)_argument,.*/\1/p' "tools/cmd_$(echo "$command" | tr - _).c" | grep -vx -e help -e version); do
    grep -qE -- "Fl -$o( |$)" "$page" || breach "$page does not name --$o"
  done
done
for ref in $(sed -nE 's/.*Xr (dexel[a-z.-]*) ([158]).*/\1.\2/p' docs/*.[1-8]); do
  [ -f "docs/$ref" ] || breach "there is no docs/$ref, to which a page refers"
done
exit $bad
