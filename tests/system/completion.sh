#!/bin/sh
# Completion for bash: of each command it offers the options that the program takes and no other; choices, files, the names of
# streams and the numbers of clients of a running service. It works without the package bash-completion.
set -u
command -v bash >/dev/null || { echo "no bash"; exit 77; }
here=$(pwd)
. "$(dirname "$0")/../expect.sh"

# complete WORD...: what it offers where the last word ends, one a line
complete() {
  bash -c '. "$0"; compopt() { :; }; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _dexel; printf "%s\n" "${COMPREPLY[@]}"' \
    "$here/config/dexel.bash-completion" "$@"
}
# offers WANTED WORD...: exactly these, in any order
offers() {
  wanted=$(printf '%s\n' $1 | sort)
  shift
  got=$(complete "$@" | sort)
  [ "$got" = "$wanted" ] || fail "'$*': offers $got, expected $wanted"
}
bash -c '. "$0"; complete -p dexel dexeld' "$here/config/dexel.bash-completion" >out 2>err || fail "it cannot be sourced: $(cat err)"
[ ! -s err ] || fail "$(cat err)"

# ---- commands and options -------------------------------------------------------------------------------
commands=$("$dexel" --help | sed -n 's/^  \([a-z][a-z-]*\) .*/\1/p')
[ "$(echo "$commands" | wc -l)" -ge 12 ] || fail "commands: $commands"
offers "$commands help --help --version" "$dexel" ''
offers 'record' "$dexel" help rec

# options_of SOURCE: in the tables for getopt_long
options_of() { sed -nE 's/^ *\{?\{?"([a-z-]+)", (no|required)_argument,.*/--\1/p' "$@"; }
export DEXELD_SOCKET="$run/none" DEXELD_CONTROL="$run/none" # no service of this machine is to hear of it
n=0
for command in $commands; do
  complete "$dexel" "$command" -- >offered
  for option in $(options_of "$here/tools/cmd_$(echo "$command" | tr - _).c"); do
    grep -qxF -- "$option" offered || fail "dexel $command $option is not offered"
  done
  # --help comes too late to be an option where another one takes it for its value; that one is wrong then
  while read -r option; do
    timeout 300 "$dexel" "$command" "$option" --help >out 2>err </dev/null
    ! grep -qE 'unrecognized option|ambiguous' err || fail "dexel $command: $option is offered: $(cat err)"
    n=$((n + 1))
  done <offered
done
[ $n -ge 120 ] || fail "$n options"
complete "$B/bin/dexeld" -- >offered
for option in $(options_of "$here/daemon/options.c"); do
  grep -qxF -- "$option" offered || fail "dexeld $option is not offered"
done
# other ways of a command
complete "$dexel" mesh --mode project -- >offered
grep -qx -- --alpha offered && ! grep -qx -- --tilt offered || fail "mesh --mode project: $(cat offered)"
complete "$dexel" bench quality -- >offered
grep -qx -- --check offered || fail "bench quality: $(cat offered)"

unset DEXELD_SOCKET DEXELD_CONTROL

# ---- choices, operands, files ---------------------------------------------------------------------------
offers 'f32 q16 delta' "$dexel" cat --encoding ''
offers 'centre nearest median mean first' "$dexel" mesh --keep ''
offers 'terrain project delaunay smooth' "$dexel" mesh --mode ''
offers 'project' "$dexel" mesh --mode p
offers 'terrain project delaunay smooth' "$dexel" mesh --mode =
offers 'project' "$dexel" mesh --mode = p
offers 'scanner front iso' "$dexel" render --view ''
offers 'plane quadric' "$dexel" mesh --mode smooth --fit ''
offers '' "$dexel" cat --frames ''
offers 'start stop status' "$dexel" record ''
offers 'pause resume status seek rate step' "$dexel" replay ''
offers 'real max' "$dexel" replay rate ''
offers '' "$dexel" replay pause ''
offers "$("$dexel" sim --list | awk '{print $1}')" "$dexel" sim ''
offers torus "$dexel" sim --surface tor
offers 'original new' "$B/bin/dexeld" --stamps ''
mkdir folder
: >scan.pcd
: >'z scan.pcd'
[ "$(complete "$dexel" mesh z)" = 'z scan.pcd' ] || fail "a file: $(complete "$dexel" mesh z)"
offers 'scan.pcd' "$dexel" mesh s
offers 'scan.pcd' "$dexel" mesh --keep = mean s
offers '' "$dexel" mesh scan.pcd s
offers 'folder' "$dexel" mesh scan.pcd -o f
offers 'scan.pcd' "$dexel" convert --frame 2 s
offers 'folder' "$dexel" convert scan.pcd f
offers 'scan.pcd' "$B/bin/dexeld" --replay s
offers '' "$run/no-such-program" ''

# ---- streams of a service -------------------------------------------------------------------------------
cat >two.yaml <<YAML
socket: $run/mesh.sock
control_socket: $run/mesh.sock.control
streams:
  - name: hall
    synthetic: {scene: hall, size: 32x16}
  - name: roof
    synthetic: {scene: sphere, size: 32x16}
YAML
start_dexeld -c two.yaml || exit 1
offers 'hall roof' "$dexel" cat --socket "$run/mesh.sock" --stream ''
offers 'roof' "$dexel" record start --socket "$run/mesh.sock.control" --stream r
offers roof "$dexel" cat --socket = "$run/mesh.sock" --stream = r
offers '' "$dexel" clients --socket "$run/mesh.sock" --disconnect ''
mkfifo said
exec 8<>said
for stream in hall roof; do
  "$dexel" cat --socket "$run/mesh.sock" --stream $stream >&8 2>&1 &
  timeout 300 grep -q -m 1 ' dexels' <&8 || fail "a client of $stream was told nothing"
done
numbers=$("$dexel" clients --socket "$run/mesh.sock" | awk 'NR > 1 {print $1}')
[ "$(echo "$numbers" | wc -l)" = 2 ] || fail "numbers of two clients: $numbers"
offers "$numbers" "$dexel" clients --socket "$run/mesh.sock" --disconnect ''
offers "$numbers" "$dexel" clients --socket = "$run/mesh.sock" --disconnect =
stop_dexeld
wait
offers '' "$dexel" cat --socket "$run/mesh.sock" --stream ''
offers '' "$dexel" clients --socket "$run/mesh.sock" --disconnect ''
exit $bad
