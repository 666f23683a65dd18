#!/bin/sh
# A reload while a reader hangs in a decode (tests/faults): its stream is left, the others go on, a new one takes its name, and the
# service ends all the same.
set -u
. tests/configured.sh

# config STREAM...
config() {
  printf 'socket: %s\ncontrol_socket: %s.control\nstreams:\n' "$sock" "$sock"
  for name; do printf '  - {name: %s, synthetic: {scene: moving-box, size: 64x48, fps: 20}}\n' "$name"; done
}
reload() {
  timeout 300 "$dexel" reload --socket "$sock" >"$run/said" 2>&1 || wrong "reload: status $?: $(cat "$run/said")"
  grep -qF -- "$1" "$run/said" || wrong "reload said '$(cat "$run/said")', expected '$1'"
}
frames() { timeout 300 "$dexel" cat --socket "$sock" --stream "$1" --frames 2 --quiet || wrong "no mesh of $1"; }
# logged TEXT: it comes, if it is not there yet
logged() { timeout 300 tail -n +1 -f "$run/dexeld.log" | grep -qF -m 1 -- "$1" || wrong "the log does not tell: $1"; }

mkdir "$run/bin"
ln -s "$(realpath "$B/tests/dexeld_faults")" "$run/bin/dexeld" # where start_dexeld looks for it
B=$run
export DEXELD_FAULT=hang-reader:3
config box >"$yaml"
start_dexeld -c "$yaml" || exit 1
logged 'fault: hang-reader'

config still >"$yaml"
reload '1 removed: box'
logged 'reload: box: its reader is still in a decode, or waits for its device'
frames still
config still box >"$yaml"
reload '1 added: box'
frames box
frames still

stop_dexeld || wrong "status $dexeld_status at the end"
logged 'service: a reader is still in a decode, or waits for its device: not waited for'
[ ! -e "$sock" ] || wrong "its socket is left"
exit $bad
