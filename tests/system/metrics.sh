#!/bin/sh
# What a service counts, as OpenMetrics on the control socket and as a file for node_exporter: the format, by a strict
# reader of our own (openmetrics.py) and by promtool where there is one; values that can be known; a disk that is
# full; and that dashboard, alert rules and manual name metrics that exist.
set -eu
. tests/daemon.sh
command -v python3 >/dev/null || { echo "there is no python3"; exit 77; }
dexel=$B/bin/dexel
export PYTHONDONTWRITEBYTECODE=1
wrong() { echo "$1"; cat "$run/dexeld.log"; exit 1; }
om() { python3 tests/system/openmetrics.py "$@"; }
metrics() { "$dexel" metrics --socket "$run/mesh.sock" "$@"; }
is() { # is VALUE NAME LABEL=VALUE...: in the text of $run/om
  expected=$1
  shift
  [ "$(om value "$run/om" "$@")" = "$expected" ] || wrong "$*: $(om value "$run/om" "$@"), expected $expected"
}
await() { # await WHAT COMMAND...
  what=$1 tries=0
  shift
  until "$@"; do
    tries=$((tries + 1))
    [ $tries -lt 3000 ] || wrong "$what does not come"
  done
}

mkdir "$run/disk" "$run/rec"
mounted=
! mount -t tmpfs -o size=64k tmpfs "$run/disk" 2>/dev/null || mounted=yes
leave() {
  [ -z "$dexeld_pid" ] || stop_dexeld || true
  [ -z "$mounted" ] || umount "$run/disk"
  at_exit
}
trap leave EXIT

"$dexel" sim moving-box -o "$run/seq" --format pcd --size 80x60 --frames 3
cat >"$run/c.yaml" <<EOF2
socket: $run/mesh.sock
control_socket: $run/mesh.sock.control
metrics_file: $run/disk/dexeld.prom
metrics_s: 1
streams:
  - name: box
    synthetic: {scene: moving-box, size: 160x120, fps: 30}
    record: {path: $run/rec/box.mcap}
  - name: still
    file: {path: $run/seq, rate: max, lossless: yes, wait: 1}
EOF2
start_dexeld -c "$run/c.yaml"
"$dexel" cat --socket "$run/mesh.sock" --stream still --quiet # to its end
"$dexel" cat --socket "$run/mesh.sock" --stream box --frames 10 --timeout 300 --quiet
"$dexel" cat --socket "$run/mesh.sock" --stream box --encoding delta --quiet &
cat_pid=$!
subscribed() { [ "$(metrics | grep -c '^dexeld_client_info{.*encoding="delta"')" = 1 ]; }
await 'a client in the metrics' subscribed

metrics >"$run/om"
om check "$run/om"
"$dexel" cat --socket "$run/mesh.sock" --stream box --frames 10 --timeout 300 --quiet
metrics >"$run/later"
om check "$run/later"
om grows "$run/om" "$run/later"
is 3 dexeld_stream_frames_total stream=still
is 1 dexeld_stream_state stream=still state=ended
is 1 dexeld_stream_state stream=box state=live
is 0 dexeld_stream_drops_total stream=still cause=corrupt
is 1 dexeld_stream_clients stream=box
is 0 dexeld_stream_clients stream=still
is 1 dexeld_recording_started stream=box
is 0 dexeld_recording_failing stream=box
is 3 dexeld_connections_total
is 3 dexeld_stream_epochs_total stream=still
grep -q "^dexeld_client_lag_seconds{client=\"3\",pid=\"$cat_pid\",stream=\"box\"} " "$run/om" || wrong 'no such client'
grep -q "^dexeld_build_info{version=\"$("$dexel" --version | cut -d' ' -f2)\"} 1\$" "$run/om" || wrong 'no version'

metrics --format prometheus >"$run/prom"
om check "$run/prom" --prometheus
code=0
metrics --format json 2>"$run/said" || code=$?
[ $code = 2 ] && grep -q "found 'json', expected openmetrics or prometheus" "$run/said" || wrong "$(cat "$run/said")"

# ---- the file: whole, for all to read, written again and again
file=$run/disk/dexeld.prom
taken() { sed -n 's/^dexeld_time_seconds //p' "$file"; }
await 'the file' [ -e "$file" ]
om check "$file" --prometheus
[ "$(stat -c %a "$file")" = 644 ] || wrong "mode $(stat -c %a "$file")"
first=$(taken)
is_newer() { [ "$(taken)" != "$first" ]; }
await 'a newer file' is_newer
said() { grep -q "$1" "$run/dexeld.log"; }
if [ -n "$mounted" ]; then
  dd if=/dev/zero of="$run/disk/ballast" bs=4096 2>/dev/null || true # until it is full
  await 'the error' said 'dexeld.prom: No space left on device; it is tried again'
  "$dexel" cat --socket "$run/mesh.sock" --stream box --frames 40 --timeout 300 --quiet || wrong 'the mesh has stopped'
  om check "$file" --prometheus # still that of before
  [ "$(ls "$run/disk")" = "ballast
dexeld.prom" ] || wrong "left: $(ls "$run/disk")"
  [ "$(grep -c 'No space left' "$run/dexeld.log")" = 1 ] || wrong 'the error was not told once'
  rm "$run/disk/ballast"
  await 'the recovery' said 'dexeld.prom: it is written again'
else
  echo 'no tmpfs can be mounted: the full disk was left out'
fi
stop_dexeld || wrong 'dexeld failed'
[ ! -e "$file" ] || wrong 'the file outlives the service'
wait $cat_pid || true

# a disk that is stuck, as a pipe that nobody reads: nothing waits for it, not even the end
mkfifo "$run/stuck.prom.new"
sed "s|^metrics_file: .*|metrics_file: $run/stuck.prom|" "$run/c.yaml" >"$run/stuck.yaml"
start_dexeld -c "$run/stuck.yaml"
"$dexel" cat --socket "$run/mesh.sock" --stream box --frames 60 --timeout 300 --quiet || wrong 'stuck: the mesh has stopped'
metrics >"$run/om" || wrong 'stuck: no answer'
stop_dexeld || wrong 'stuck: dexeld failed'
[ ! -e "$run/stuck.prom" ] || wrong 'a stuck disk has a file'

# what is there and has no metrics in it is left alone, the configuration under another name among it
mkdir "$run/folder.prom"
echo mine >"$run/mine.prom"
ln -s "$run/mine.yaml" "$run/link.prom"
refuses() { # refuses NAME TEXT
  sed "s|^metrics_file: .*|metrics_file: $run/$1|" "$run/c.yaml" >"$run/mine.yaml"
  code=0
  timeout 300 "$B/bin/dexeld" -c "$run/mine.yaml" 2>"$run/said" || code=$?
  [ $code = 1 ] && grep -q "metrics_file: $run/$1: $2" "$run/said" || wrong "$1: $code, $(cat "$run/said")"
}
refuses folder.prom 'found what is no regular file'
refuses mine.prom 'found a file that has no metrics in it'
refuses link.prom 'found a file that has no metrics in it'
[ "$(cat "$run/mine.prom")" = mine ] && [ -s "$run/mine.yaml" ] || wrong 'a file is gone'
# an older one is not
cp "$run/prom" "$run/old.prom"
sed "s|^metrics_file: .*|metrics_file: $run/old.prom|" "$run/c.yaml" >"$run/old.yaml"
start_dexeld -c "$run/old.yaml" || wrong 'a file of before is in its way'
stop_dexeld || wrong 'dexeld failed'

# ---- what names metrics
om used "$run/om" config/grafana/dexeld.json config/prometheus/dexeld.rules.yml
om documented "$run/om" docs/operations.md
if command -v promtool >/dev/null; then
  promtool check metrics <"$run/prom" || wrong 'promtool finds fault with the metrics'
  promtool check rules config/prometheus/dexeld.rules.yml
  promtool test rules tests/system/metrics_rules.yml
else
  echo 'there is no promtool (Debian: prometheus): its checks were left out'
fi
