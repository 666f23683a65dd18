#!/bin/sh
# Streams recorded by the daemon and replayed: a sequence of files at rate max gives the same meshes, epoch by
# epoch, as the first run, whether it lies in one recording or in several, from its start or after a seek;
# a simulated stream ends in the same mesh, at real time too. The control socket moves a replay.
set -eu
. tests/daemon.sh
dexel=$B/bin/dexel
frames=12
wrong() { echo "$1"; cat "$run/dexeld.log"; exit 1; }
sock=$run/mesh.sock
replay() { "$dexel" replay "$@" --socket "$sock"; }
digest() { grep -o '"digest": "[0-9a-f]*"' "$1"; }
# await COMMAND TEXT: until the command says it
await() {
  tries=0
  until $1 | grep -q "$2"; do
    tries=$((tries + 1))
    [ $tries -lt 3000 ] || wrong "'$1' never said '$2': $($1)"
  done
}
# catch NAME: every epoch of a lossless replay, as meshes NAME-000000.ply ...
catch() { "$dexel" cat --socket "$sock" --lossless -o "$run/$1-%06d.ply" --every --stats --quiet >"$run/$1.json"; }
# same NAME FIRST N: N meshes of NAME from number FIRST on are those of the first run from frame FIRST + $4 on
same() {
  n=0
  while [ $n -lt "$3" ]; do
    cmp "$run/$1-$(printf %06d $(($2 + n))).ply" "$run/first-$(printf %06d $(($2 + n + $4))).ply" || wrong "$1"
    n=$((n + 1))
  done
}

"$dexel" sim moving-box -o "$run/scan" --format pcd --size 160x120 --noise 0.002 --dropouts 0.01 --frames $frames
config() { # compression and more of record
  cat <<YAML
socket: $sock
control_socket: $sock.control
streams:
  - name: scan
    file: {path: $run/scan, rate: max, lossless: yes, wait: 1}
    mesh: {diag: short, tilt: 70, sigma: [0.002, 0, 0]}
    record: {path: $run/$1-%Y.mcap, $2}
YAML
}

# ---- the first run, in one file
config one 'compression: zstd' >"$run/one.yaml"
start_dexeld -c "$run/one.yaml"
catch first
stop_dexeld
grep -q "\"commits\": $frames, " "$run/first.json" || wrong "first run: $(cat "$run/first.json")"
one=$(ls "$run"/one-*.mcap)
"$B/tests/record_check" "$one" | grep -q "^blocks $frames first 0 last $((frames - 1)) lost 0 damages 0" ||
  wrong "recording: $("$B/tests/record_check" "$one")"

# ---- in several files: rotation loses nothing
config many 'compression: none, split_mib: 1' >"$run/many.yaml"
start_dexeld -c "$run/many.yaml"
catch second
stop_dexeld
[ "$(ls "$run"/many-*.mcap | wc -l)" -gt 2 ] || wrong "no rotation: $(ls -l "$run"/many-*)"
"$B/tests/record_check" "$run"/many-*.mcap | grep -q "^blocks $frames first 0 .* lost 0 damages 0" || wrong "rotation"
mv "$run/scan" "$run/gone" # a recording replays by itself

# ---- replayed at max, meshed as it was then: every epoch
start_dexeld --replay "$one" --rate max --socket "$sock"
catch again
await 'replay status --json' '"ended":true'
stop_dexeld
same again 0 $frames 0
start_dexeld --replay "$run/many-*.mcap" --rate max --socket "$sock"
catch several
stop_dexeld
same several 0 $frames 0
# the last of the files alone: its blocks are in the geometry that it carries
last=$(ls "$run"/many-*.mcap | tail -n 1)
n=$("$B/tests/record_check" "$last" | sed 's/blocks \([0-9]*\) .*/\1/')
start_dexeld --replay "$last" --rate max --socket "$sock"
catch tail
stop_dexeld
same tail 0 "$n" $((frames - n))
# its geometry damaged: that is told, once, and with its place
cp "$last" "$run/bent.mcap"
type=application/x-dexel-geometry
at=$(($(grep -abo -m 1 $type "$run/bent.mcap" | head -n 1 | cut -d : -f 1) + ${#type} + 8 + 20)) # behind the length of its data
printf '\377' | dd of="$run/bent.mcap" bs=1 seek=$at conv=notrunc 2>"$run/err" || wrong "$(cat "$run/err")"
start_dexeld --replay "$run/bent.mcap" --rate max --socket "$sock"
catch bent
stop_dexeld
[ "$(grep -c 'bent.mcap: the geometry of its frames cannot be used, .*: byte [0-9]*: attachment: CRC' "$run/dexeld.log")" = 1 ] ||
  wrong "a damaged geometry was not told"
grep -q "\"commits\": $n, " "$run/bent.json" || wrong "bent: $(cat "$run/bent.json")"

# ---- steps, seek, and on to the end
start_dexeld --replay "$one" --rate max --socket "$sock"
replay pause >"$run/out"
grep -q '^paused at 0.000 of ' "$run/out" || wrong "pause: $(cat "$run/out")"
catch moved &
cat_pid=$!
replay step 3 >"$run/out"
await 'replay status --json' '"frames":3'
replay seek 0 >"$run/out"
replay step 2 >"$run/out"
await 'replay status --json' '"frames":5'
replay resume >"$run/out"
wait $cat_pid
stop_dexeld
grep -q "\"commits\": $((frames + 3)), " "$run/moved.json" || wrong "moved: $(cat "$run/moved.json")"
same moved 0 3 0
same moved 3 $frames -3

# ---- to a time in the middle: the frames from there on
start_dexeld --replay "$one" --rate max --socket "$sock"
half=$(replay status --json | sed 's/.*"length_s":\([0-9.e-]*\).*/\1/' | awk '{print $1 / 2}')
replay seek "$half" >"$run/out"
catch late
stop_dexeld
n=$(grep -o '"commits": [0-9]*' "$run/late.json" | grep -o '[0-9]*')
[ "$n" -gt 0 ] && [ "$n" -lt $frames ] || wrong "seek to the middle: $n of $frames frames"
same late 0 "$n" $((frames - n))

# ---- refusals
start_dexeld --replay "$one" --rate real --wait 1 --socket "$sock"
if replay seek never 2>"$run/err"; then wrong "seek never"; fi
if "$dexel" record start --socket "$sock" 2>"$run/err"; then wrong "record of a replay without a path"; fi
grep -q "stream 'replay' has no record.path" "$run/err" || wrong "$(cat "$run/err")"
replay rate 2 | grep -q 'rate 2$' || wrong "rate 2"
stop_dexeld

# ---- a simulated stream in parts, its recording started and stopped
cat >"$run/live.yaml" <<YAML
socket: $sock
control_socket: $sock.control
streams:
  - name: box
    synthetic: {scene: moving-box, size: 64x48, noise: 0.002, fps: 100, frames: 60, parts: 16, wait: 1}
    mesh: {sigma: [0.002, 0, 0]}
    record: {path: "$run/box.mcap", start: no}
YAML
record() { "$dexel" record "$@" --socket "$sock"; }
start_dexeld -c "$run/live.yaml"
record status | grep -q '^stopped: 0 blocks' || wrong "$(record status)"
record start --stream box >"$run/out"
"$dexel" cat --socket "$sock" --stats --quiet >"$run/live.json"
record stop >"$run/out"
await 'record status --json' '"writing":false'
if replay pause 2>"$run/err"; then wrong "pause of a live stream"; fi
stop_dexeld
"$B/tests/record_check" "$run/box.mcap" >"$run/out"
grep -q ' first 0 last 239 lost 0 damages 0' "$run/out" || wrong "box: $(cat "$run/out")"
for rate in max real; do
  start_dexeld --replay "$run/box.mcap" --rate $rate --wait 1 --socket "$sock"
  "$dexel" cat --socket "$sock" --stats --quiet >"$run/box.json"
  stop_dexeld
  [ "$(digest "$run/box.json")" = "$(digest "$run/live.json")" ] || wrong "box at $rate: $(cat "$run/box.json")"
done
