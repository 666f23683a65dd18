# Sourced by scripts: a dexeld of one's own, awaited without sleeping and stopped at the exit.
#   start_dexeld ARGS...   starts it, returns when its sockets listen; its log is $run/dexeld.log
#   stop_dexeld            SIGTERM, and its exit status
# $run is a folder that goes with the script.
B=${B:-build}
run=$(mktemp -d)
dexeld_pid=

start_dexeld() {
  rm -f "$run/ready"
  mkfifo "$run/ready"
  "$B/bin/dexeld" "$@" --ready-fd 9 9>"$run/ready" 2>>"$run/dexeld.log" &
  dexeld_pid=$!
  # end of file without a line: it could not start
  read -r _ <"$run/ready" || { wait "$dexeld_pid"; dexeld_pid=; cat "$run/dexeld.log" >&2; return 1; }
}

stop_dexeld() {
  kill "$dexeld_pid"
  dexeld_status=0
  wait "$dexeld_pid" || dexeld_status=$?
  dexeld_pid=
  return $dexeld_status
}

at_exit() {
  # after Ctrl-C, which the terminal sent to dexeld as well, it may be gone
  [ -z "$dexeld_pid" ] || stop_dexeld 2>/dev/null || true
  rm -rf "$run"
}
trap at_exit EXIT
trap 'exit 130' INT
trap 'exit 143' TERM
