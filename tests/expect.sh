# Sourced by scripts that run the programs with good and bad words: in a folder of their own ($run), with $dexel and
# the daemon's functions (daemon.sh). What fails is said and remembered in $bad, the script's exit status.
B=$(cd "${B:-build}" && pwd)
. "$(dirname "$0")/../daemon.sh"
dexel=$B/bin/dexel
cd "$run" || exit 1
bad=0

fail() { echo "$*"; bad=1; }
# expect STATUS COMMAND...; output in out and err
expect() {
  expected=$1
  shift
  "$@" >out 2>err
  got=$?
  [ $got = "$expected" ] || { fail "exit $got, expected $expected: $*"; cat err; }
}
# says TEXT [FILE]: it stands in the standard error, or in FILE
says() { grep -qF -- "$1" "${2:-err}" || { fail "expected '$1' in:"; cat "${2:-err}"; }; }
# of the JSON in out
number() { sed -n 's/.*"'"$1"'": \([-0-9.e+]*\).*/\1/p' out; }
digest() { sed 's/.*"digest": "\([0-9a-f]*\)".*/\1/' out; }
