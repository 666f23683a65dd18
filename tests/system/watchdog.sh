#!/bin/sh
# The watchdog: fed while all is well, whatever the threads wait for (a device that is absent, a replay that is paused, a
# source whose next frame is far off, subscribers, a disk that does not answer), and no longer once the loop, a reader or a
# mesher hangs; the log names which. The service manager is manager.c.
set -u
. tests/daemon.sh
limit_ms=4000
"$B/tests/sanitized" || limit_ms=20000 # half of it for a step of a thread, on a busy machine
bad=0
wrong() { echo "wrong: $*"; bad=1; }

# config NAME STREAM...: the configuration of a service of that name
config() {
  printf 'socket: %s\ncontrol_socket: %s.control\nstreams:\n' "$run/$1.sock" "$run/$1.sock" >"$run/$1.yaml"
  name=$1
  shift
  printf '  - %s\n' "$@" >>"$run/$name.yaml"
}

# manage NAME [FAULT]: the service under its manager, in the background; what that is told is in $run/NAME.told
manage() {
  DEXELD_FAULT=${2:-} "$B/tests/manager" $limit_ms "$B/tests/dexeld_faults" -c "$run/$1.yaml" >"$run/$1.told" 2>"$run/$1.log" &
  managers="$managers $!"
}
managers=
trap 'kill $managers 2>/dev/null; at_exit' EXIT

# feeds N NAME: the next N times that descriptor 7 tells something of it, all is well
feeds() {
  n=0
  while [ $n -lt "$1" ]; do
    read -r line <&7 || line=ended
    case $line in
      WATCHDOG=1) n=$((n + 1)) ;;
      hung | ended) wrong "$2: $line after $n feeds; $(cat "$run/$2.log")"; return ;;
    esac
  done
  echo "$2: fed $n times"
}

box='{name: box, synthetic: {scene: moving-box, size: 64x48, fps: 20}'
"$B/bin/dexel" sim sphere -o "$run/a.pcd" --size 64x48 && "$B/bin/dexel" convert "$run/a.pcd" "$run/a.mcap" || exit 1

# three that hang, beside all that follows
for thread in loop reader mesher; do
  config $thread "$box}"
  manage $thread hang-$thread:3
  eval "$thread=$!"
done

# well through more than twice the time of a manager
config waiting '{name: absent, kinect: {serial: nowhere}}' '{name: rare, synthetic: {scene: sphere, size: 64x48, fps: 0.001}}' \
  "{name: ended, file: {path: $run/a.pcd}}" "{name: held, file: {path: $run/a.pcd, rate: max, lossless: yes, wait: 1}}" \
  "{name: paused, file: {path: $run/a.mcap, rate: 0.001, loop: yes}}"
mkfifo "$run/waiting.told"
manage waiting
waiting=$!
exec 7<"$run/waiting.told"
feeds 1 waiting
"$B/bin/dexel" replay pause --stream paused --socket "$run/waiting.sock" >/dev/null || wrong "the replay cannot be paused"
feeds $((2 * limit_ms / 1000 + 1)) waiting # one a second
kill $waiting
wait $waiting || wrong "waiting: status $? at its end; $(cat "$run/waiting.log")"
grep -q watchdog "$run/waiting.log" && wrong "waiting: said $(grep watchdog "$run/waiting.log")"

# a disk that does not answer: told, and no reason to begin anew
config disk "$box, record: {path: $run/rec.mcap}}"
mkfifo "$run/disk.told"
manage disk hang-recorder
disk=$!
exec 7<"$run/disk.told"
feeds $((limit_ms / 2000 + 4)) disk
grep -q 'watchdog: box: the recorder waits for its disk' "$run/disk.log" || wrong "disk: not told; $(cat "$run/disk.log")"
"$B/bin/dexel" record status --socket "$run/disk.sock" --json | grep -q '"stuck_s":' || wrong "disk: the status does not tell"
kill $disk
wait $disk || wrong "disk: status $? at its end; $(cat "$run/disk.log")"

for thread in loop reader mesher; do
  eval "wait \$$thread"
  status=$?
  [ $status = 3 ] || wrong "hang-$thread: status $status, expected that it was killed"
  grep -q "^fault: hang-$thread" "$run/$thread.log" || wrong "hang-$thread: did not hang; $(cat "$run/$thread.log")"
  [ "$(tail -n 1 "$run/$thread.told")" = hung ] || wrong "hang-$thread: told '$(tail -n 1 "$run/$thread.told")'"
  echo "$thread: $(grep watchdog "$run/$thread.log" || echo 'nothing is told')"
done
for thread in reader mesher; do
  grep -q "watchdog: box: the $thread hangs: no sign of it for .* s; the service is to be started anew" "$run/$thread.log" ||
    wrong "hang-$thread: not told; $(cat "$run/$thread.log")"
done
managers=
exit $bad
