#!/bin/sh
# The configuration is read again while the service runs: what subscribers of each stream see (reload_watch.c), what a service
# manager is told, what is refused and changes nothing, what counts from the next start only, and that reloads leave
# nothing behind.
set -u
. tests/configured.sh

top() { printf 'socket: %s\ncontrol_socket: %s.control\n' "$sock" "$sock"; }
# stream NAME SYNTHETIC...
stream() { printf '  - name: %s\n    synthetic: {%s}\n' "$1" "$2"; }
still='scene: moving-box, size: 160x120, noise: 0.001, fps: 8'
box='scene: moving-box, size: 100x80, fps: 8'
box2='scene: moving-box, size: 260x180, noise: 0.002, fps: 8'

# says STATUS TEXT: what `dexel reload` does
says() {
  code=0
  timeout 300 "$dexel" reload --socket "$sock" >"$run/said" 2>&1 || code=$?
  [ $code = "$1" ] || wrong "reload: status $code, expected $1: $(cat "$run/said")"
  grep -qF -- "$2" "$run/said" || wrong "reload said '$(cat "$run/said")', expected '$2'"
}
# hears WHAT: the service manager is told of a reload (of the state between: notify.sh)
hears() {
  for expected in RELOADING=1 MONOTONIC_USEC= READY=1; do
    read -r line <&7
    while [ "${line#STATUS=}" != "$line" ]; do read -r line <&7; done
    case $line in $expected*) ;; *) wrong "$1: told '$line', expected $expected" ;; esac
  done
}
frames() { timeout 300 "$dexel" cat --socket "$sock" --stream "$1" --frames 2 --quiet || wrong "no mesh of $1"; }

# ---- what subscribers see, and what the service manager is told
"$dexel" sim sphere -o "$run/scan.pcd" --size 240x160 || exit 1
lossless() { printf '  - name: run\n    file: {path: %s/scan.pcd, rate: max, lossless: yes, loop: yes, wait: 1}\n' "$run"; }
{ top; echo streams:; stream still "$still"; lossless; stream box "$box"; stream gone "$box"; } >"$yaml"
{ top; echo '# one line more'; echo streams:; stream come "$box"; stream box "$box2"; stream still "$still"; lossless; } >"$run/next"
mkfifo "$run/told"
"$B/tests/notified" "$run/notify" >"$run/told" &
notified=$!
exec 7<"$run/told"
read -r line <&7 # it listens
export NOTIFY_SOCKET="$run/notify"
start_dexeld -c "$yaml" || exit 1
unset NOTIFY_SOCKET
read -r line <&7
[ "$line" = READY=1 ] || wrong "at the start told '$line'"
timeout 300 "$B/tests/reload_watch" "$sock" "$sock.control" "$yaml" "$run/next" || wrong "subscribers at a reload"
hears "a reload"

# ---- by SIGHUP
{ top; echo streams:; stream still "$still"; stream hup "$box"; } >"$yaml"
kill -HUP "$dexeld_pid"
hears SIGHUP
frames hup

# ---- what is refused changes nothing
cp "$yaml" "$run/good.yaml"
{ top; echo streams:; stream still "$box"; stream hup "$box" | sed 's/fps: 8/fps: often/'; } >"$yaml"
says 1 "$yaml:7:"
grep -qF "$yaml:7:" "$run/dexeld.log" || wrong "the log does not say why"
rm "$yaml"
says 1 "$yaml: No such file"
{ cat "$run/good.yaml"; stream more "$box"; printf '  - name: scan\n    file: {path: %s/none.pcd}\n' "$run"; } >"$yaml"
says 1 "$yaml:10: stream scan: "
"$dexel" cat --socket "$sock" --stream more --frames 1 --quiet 2>/dev/null && wrong "a refused reload added a stream"
sed -i "s|none.pcd|dexeld.log|" "$yaml" # it is there, and is no scan
says 1 "$yaml:10: stream scan: $run/dexeld.log: neither PTX nor PCD nor MCAP"
frames hup
cp "$run/good.yaml" "$yaml"
says 0 "0 added"
grep -qF "2 unchanged: still, hup" "$run/said" || wrong "reload said '$(cat "$run/said")'"

# ---- the same at a start ends it, with the same text
printf 'socket: %s/none.sock\nstreams:\n  - name: scan\n    file: {path: %s/none.pcd}\n' "$run" "$run" >"$run/none.yaml"
code=0
timeout 300 "$B/bin/dexeld" -c "$run/none.yaml" 2>"$run/said" || code=$?
[ $code = 1 ] || wrong "a start without its scan: status $code, expected 1"
grep -qxF "dexeld: $run/none.yaml:3: stream scan: $run/none.pcd: No such file or directory" "$run/said" ||
  wrong "a start without its scan said '$(cat "$run/said")'"
"$B/bin/dexeld" -c "$run/none.yaml" --check >"$run/said" || wrong "--check looked for the scan"

# ---- what counts from the next start on; the rest is applied
sed -e "s|^socket: .*|socket: $run/other.sock|" -e '2a threads: 1\nlog_level: debug' -e 's/name: hup/name: hop/' "$run/good.yaml" >"$yaml"
says 0 "from the next start on: socket, threads"
frames hop
[ ! -e "$run/other.sock" ] || wrong "a socket was made at the new path"
grep -qF "socket: the value in $yaml counts from the next start on" "$run/dexeld.log" || wrong "the log does not tell of the socket"
grep -q "server: client .* connected" "$run/dexeld.log" || wrong "the log level was not applied"

# ---- the configuration in force: what was told above, and as a file again
"$dexel" config --socket "$sock" >"$run/force.yaml" || wrong "dexel config: status $?"
has() { grep -qxF -- "$1" "$run/force.yaml" || wrong "dexel config has no line '$1': $(cat "$run/force.yaml")"; }
has "socket: \"$sock\"  # as at the start; from the next on: $yaml:1"
has "threads: 0  # as at the start; from the next on: $yaml:3"
has "log_level: debug  # $yaml:4"
has "max_clients: 256  # default"
has "  - name: \"hop\"  # $yaml:8"
has "      size: 100x80  # $yaml:9"
has "      tilt: 78.69  # default"
"$B/bin/dexeld" -c "$run/force.yaml" --check >/dev/null || wrong "what is in force is not taken as a configuration"
cp "$run/force.yaml" "$yaml"
says 0 "2 unchanged: still, hop"
grep -qF "from the next start on" "$run/said" && wrong "what is in force is not in force: $(cat "$run/said")"

# ---- reloads leave nothing behind
{ top; echo streams:; stream still "$still"; stream box "$box"; stream gone "$box"; } >"$run/a"
{ top; echo streams:; stream still "$still"; stream come "$box"; stream box "$box2"; } >"$run/b"
count() {
  "$dexel" status --socket "$sock" >/dev/null # the loop has seen then who has just gone
  ls "/proc/$dexeld_pid/$1" | wc -l
}
twice() {
  cp "$run/a" "$yaml" && says 0 "1 unchanged: still"
  frames box
  cp "$run/b" "$yaml" && says 0 "1 unchanged: still"
  frames box
}
"$dexel" cat --socket "$sock" --stream still --quiet &
client=$!
warm=5 more=25
"$B/tests/sanitized" || { warm=1 more=2; } # where memory is written when it is taken, and again for the shadow of it
n=0
while [ $((n += 1)) -le $warm ]; do twice; done
fds=$(count fd) tasks=$(count task) rss=$(sed -n 's/^VmRSS:[^0-9]*\([0-9]*\).*/\1/p' "/proc/$dexeld_pid/status")
n=0
while [ $((n += 1)) -le $more ]; do twice; done
rss_after=$(sed -n 's/^VmRSS:[^0-9]*\([0-9]*\).*/\1/p' "/proc/$dexeld_pid/status")
echo "after $((2 * more)) reloads more: $fds and $(count fd) descriptors, $tasks and $(count task) threads, $rss and $rss_after KiB"
[ "$(count fd)" = "$fds" ] || wrong "descriptors are left"
[ "$(count task)" = "$tasks" ] || wrong "threads are left"
if "$B/tests/sanitized"; then
  [ $((rss_after - rss)) -lt 16384 ] || wrong "memory grows"
fi
kill $client
wait $client 2>/dev/null

# ---- the end in the middle of a reload; a sanitizer makes it so long that it is not waited for, and then tells of threads
cp "$run/a" "$yaml"
"$B/tests/sanitized" && kill -HUP "$dexeld_pid"
stop_dexeld || wrong "status $dexeld_status after SIGTERM during a reload"
kill $notified

# ---- without a file
start_dexeld --replay "$run/scan.pcd" --loop --socket "$sock" || exit 1
says 1 "there is no configuration file to read again"
"$dexel" config --socket "$sock" >"$run/force.yaml" || wrong "dexel config: status $?"
has "      loop: yes  # the command line"
has "      path: \"$run/scan.pcd\"  # the command line"
has "      exact: no  # default"
kill -HUP "$dexeld_pid"
timeout 300 "$dexel" cat --socket "$sock" --frames 2 --quiet || wrong "a replay did not survive SIGHUP"
stop_dexeld || wrong "status $dexeld_status of a replay"
exit $bad
