#!/bin/sh
# What the service manager is told of the service, in a line: at the start, when streams and clients come, change and go, while a
# reload is refused, and at the end. That the log says what was started.
set -u
. tests/configured.sh

mkfifo "$run/told"
"$B/tests/notified" "$run/notify" >"$run/told" &
notified=$!
trap 'kill $notified 2>/dev/null; at_exit' EXIT
exec 7<"$run/told"
read -r line <&7 # it listens

# tells PATTERN: the next line. comes PATTERN: one of the next, those before it are lines of status
tells() {
  read -r line <&7
  case $line in $1) ;; *) wrong "told '$line', expected '$1'" ;; esac
}
comes() {
  while read -r line <&7; do
    echo "$line"
    case $line in
      $1) return ;;
      STATUS=*) ;;
      *) break ;;
    esac
  done
  wrong "told '$line', expected '$1'"
}

"$dexel" sim sphere -o "$run/scan.pcd" --size 64x48 || exit 1
top() { printf 'socket: %s\ncontrol_socket: %s.control\nstreams:\n' "$sock" "$sock"; }
box='  - {name: box, synthetic: {scene: moving-box, size: 64x48, fps: 8}}'
over="  - {name: over, file: {path: $run/scan.pcd, wait: 1}}"
far='  - {name: far, kinect: {serial: nowhere}}'

# ---- the start
{ top; echo "$box"; echo "$over"; echo "$far"; } >"$yaml"
export NOTIFY_SOCKET="$run/notify"
start_dexeld -c "$yaml" || exit 1
tells READY=1
tells 'STATUS=3 streams, 0 live, box: opening, over: opening, far: opening; 0 clients'
version=$("$B/bin/dexeld" --version | cut -d' ' -f2)
grep -qxF "dexeld: service: version $version, $yaml: 3 streams; mesh $sock, control $sock.control" "$run/dexeld.log" ||
  wrong "the log does not say what was started: $(cat "$run/dexeld.log")"

# ---- streams and clients change
comes 'STATUS=3 streams, 1 live, over: opening, far: gone; 0 clients'
"$dexel" cat --socket "$sock" --stream box --quiet &
client=$!
comes 'STATUS=3 streams, 1 live, over: opening, far: gone; 1 client'
timeout 300 "$dexel" cat --socket "$sock" --stream over --quiet || wrong "no mesh of over"
comes 'STATUS=3 streams, 1 live, over: ended, far: gone; 1 client'
kill $client
wait $client
comes 'STATUS=3 streams, 1 live, over: ended, far: gone; 0 clients'

# ---- a refusal stays until a reload is done; nothing of a file makes a line of its own
{ top; echo "$box"; printf '  - {name: bad, synthetic: {scene: "ball\\nREADY=0", size: 64x48}}\n'; } >"$yaml"
kill -HUP "$dexeld_pid"
comes RELOADING=1
tells 'MONOTONIC_USEC=*'
comes READY=1
tells "STATUS=3 streams, 1 live, over: ended, far: gone; 0 clients; reload refused: $yaml:5:*READY=0*"
"$dexel" cat --socket "$sock" --stream box --quiet &
client=$!
comes 'STATUS=*; 1 client; reload refused: *'
{ top; echo "$box"; } >"$yaml"
kill -HUP "$dexeld_pid"
comes RELOADING=1
tells 'MONOTONIC_USEC=*'
comes READY=1
tells 'STATUS=1 stream, 1 live; 1 client'

# ---- many that are not live, with the longest names
long=$(printf %063d 0)
{ top; for k in 1 2 3 4 5; do echo "  - {name: $k${long#0}, kinect: {serial: nowhere}}"; done; } >"$yaml"
kill -HUP "$dexeld_pid"
comes RELOADING=1
tells 'MONOTONIC_USEC=*'
comes READY=1
comes "STATUS=5 streams, 0 live, 1${long#0}: gone, 2${long#0}: gone, 3 more; 0 clients"
[ ${#line} -lt 207 ] || wrong "a line of ${#line} bytes"

# ---- the end
kill "$dexeld_pid"
comes STOPPING=1
tells STATUS=
wait "$dexeld_pid" || wrong "status $? at the end"
dexeld_pid=
exit $bad
