#!/bin/sh
# In a guest: runs the tests of a folder ($HIL_TESTS below $HIL_ROOT, else /tests/hil/guest), or those named, one after the other; a
# line for each on standard output, "N passed, N failed" at the end; all that they wrote goes to the console.
# A test is a script; exit 0 passed, 77 skipped, anything else failed. `# limit: N` in it: seconds, else 30;
# hil_limit=N on the kernel's command line: for all.
# What a test leaves running is killed after it.
set -u
export B=/
folder=${HIL_TESTS:-tests/hil/guest}
label=${HIL_LABEL:-hil}
log=/run/hil
mkdir -p $log
passed=0 failed=0 skipped=0

# what is left of session $1, the test's own
kill_session() {
  for stat in /proc/[0-9]*/stat; do
    read -r line <"$stat" || continue
    pid=${line%% *}
    # state, parent, group, session
    # shellcheck disable=SC2086 # words
    set -- "$1" ${line##*) }
    [ "$5" = "$1" ] && kill -KILL "$pid"
  done 2>/dev/null
}

# told: what the system has told last
told() {
  if [ -d /run/systemd/system ]; then journalctl --no-pager -n 80; else dmesg | tail -n 30; fi
}

run() {
  name=$(basename "$1" .sh)
  limit=$(sed -n 's/.*\bhil_limit=\([0-9]*\).*/\1/p' /proc/cmdline)
  [ -n "$limit" ] || limit=$(sed -n 's/^# limit: //p' "$1")
  setsid timeout -s KILL "${limit:-30}" sh "$1" >"$log/$name" 2>&1 </dev/null &
  session=$!
  wait $session
  code=$?
  kill_session $session
  {
    read -r up _ </proc/uptime
    echo "---- $name: status $code, at $up s"
    cat "$log/$name"
    [ $code = 0 ] || [ $code = 77 ] || told
  } >/dev/console
  case $code in
    0) passed=$((passed + 1)); echo "pass  $label/$name" ;;
    77) skipped=$((skipped + 1)); echo "skip  $label/$name: $(tail -n 1 "$log/$name")" ;;
    137) failed=$((failed + 1)); echo "FAIL  $label/$name: more than ${limit:-30} s"; tail -n 40 "$log/$name" | sed 's/^/      /' ;;
    *) failed=$((failed + 1)); echo "FAIL  $label/$name"; tail -n 40 "$log/$name" | sed 's/^/      /' ;;
  esac
}

cd "${HIL_ROOT:-/}" || exit 1
if [ $# -gt 0 ]; then for t in "$@"; do run "$folder/$t.sh"; done
else for t in "$folder"/*.sh; do run "$t"; done; fi

line="$passed passed, $failed failed"
[ $skipped = 0 ] || line="$line, $skipped skipped"
echo "$line"
