#!/bin/sh
# Scans to recordings and to messages of ROS and back: a recording of scans has the mesh of the scans in every tool
# and in the service, clouds have the points that PCD has, and what cannot be is told with the right status.
set -u
. "$(dirname "$0")/../expect.sh"
tells() { grep -qE -- "$1" out || { fail "expected '$1' in:"; cat out; }; }
mesh() { "$dexel" mesh "$@" --stats 2>err | sed 's/.*"digest": "\([0-9a-f]*\)".*/\1/'; cat err >&2; }
# same WHAT A B: two digests
same() { [ -n "$2" ] && [ "$2" = "$3" ] || fail "$1: mesh $3, expected $2"; }
# replay_digest PATH: the mesh that the service ends with
replay_digest() {
  start_dexeld --replay "$1" --rate max --wait 1 --socket "$run/mesh.sock" >&2 || exit 1
  "$dexel" cat --socket "$run/mesh.sock" --lossless --stats --quiet | sed 's/.*"digest": "\([0-9a-f]*\)".*/\1/'
  stop_dexeld >&2
}

"$dexel" sim moving-box -o seq --size 160x120 --frames 4 --noise 0.002 --dropouts 0.01 --attr 16 --format pcd
"$dexel" sim hall -o hall.ptx --size 300x130 --noise 0.004 --attr 16
gzip -k hall.ptx

# ---- every kind of scan to a recording: the same mesh in the tools and in the service
for scan in seq hall.ptx hall.ptx.gz; do
  for options in '' '--exact' '--size 100x90 --unit 0.001'; do
    # shellcheck disable=SC2086 # words
    expect 0 "$dexel" convert "$scan" run.mcap $options
    # shellcheck disable=SC2086
    want=$(mesh "$scan" $options)
    same "$scan $options" "$want" "$(mesh run.mcap)"
    [ "$options" = --exact ] || same "$scan $options, replayed" "$want" "$(replay_digest run.mcap)"
  done
done

# ---- as the service records it
expect 0 "$dexel" convert seq run.mcap
"$B/tests/record_check" run.mcap >out || fail 'no sound recording'
tells '^blocks 4 first 0 last 3 lost 0 damages 0'
expect 0 "$dexel" info run.mcap --json
for what in '"topic": "/dexel/raw"' '"driver": "file"' '"name": "dexeld.yaml"' '"name": "geometry"' '"frames": 4' \
  '"geometry": "pinhole", "width": 160, "height": 120'; do
  tells "$what"
done
cat >dexeld.yaml <<YAML
socket: $run/mesh.sock
control_socket: $run/mesh.sock.control
streams:
  - name: scan
    file: {path: $run/seq, rate: max, lossless: yes, wait: 1}
    record: {path: $run/service.mcap}
YAML
start_dexeld -c dexeld.yaml || exit 1
"$dexel" cat --socket mesh.sock --lossless --quiet
stop_dexeld || fail 'dexeld failed'
expect 0 "$dexel" convert service.mcap ours
expect 0 "$dexel" convert run.mcap again
diff -r ours again >out || fail "frames of the service's recording differ: $(cat out)"
expect 0 "$dexel" convert service.mcap copy.mcap
same 'a copy of a recording' "$(mesh seq)" "$(mesh copy.mcap)"

# ---- frames of a recording, to each format: those of the scans
for format in ptx pcd; do
  rm -rf of_scans of_recording
  expect 0 "$dexel" convert seq of_scans --format $format
  expect 0 "$dexel" convert run.mcap of_recording --format $format
  diff -r of_scans of_recording >out || fail "$format: $(cat out)"
  [ "$(ls of_scans | wc -l)" = 4 ] || fail "$format: $(ls of_scans)"
  expect 0 "$dexel" convert run.mcap one.$format --frame 2
  cmp one.$format of_scans/frame-000002.$format || bad=1
done
expect 1 "$dexel" convert run.mcap one.pcd --frame 4
says 'run.mcap: found 4 frames, expected one of number 4'
expect 0 "$dexel" convert run.mcap third.mcap --frame 2
same 'a frame of a recording' "$(mesh seq --frame 2 --sigma 0.002)" "$(mesh third.mcap --sigma 0.002)"
expect 0 "$dexel" render run.mcap -o a.png --size 200x100
expect 0 "$dexel" render seq -o b.png --size 200x100
cmp a.png b.png || bad=1

# ---- a damaged frame that was recorded is told and passed over, as the service does
cp -r seq holed
head -c 3000 seq/frame-000001.pcd >holed/frame-000001.pcd
expect 1 "$dexel" convert holed out.mcap; says frame-000001.pcd
sed "s|$run/seq|$run/holed|; s|service.mcap|holed.mcap|" dexeld.yaml >holed.yaml
start_dexeld -c holed.yaml || exit 1
"$dexel" cat --socket mesh.sock --lossless --quiet
stop_dexeld || fail 'dexeld failed'
expect 0 "$dexel" convert holed.mcap of_holed --format pcd; says frame-000001.pcd
[ "$(ls of_holed | wc -l)" = 3 ] || fail "holed: $(ls of_holed)"
cmp of_holed/frame-000002.pcd of_scans/frame-000003.pcd || bad=1
expect 0 "$dexel" convert holed.mcap copy.mcap
"$B/tests/record_check" copy.mcap >out 2>&1
tells '^blocks 4 first 0 last 3 lost 0 damages 0'

# ---- parts of frames, as line scanners give them
cat >parts.yaml <<YAML
socket: $run/mesh.sock
control_socket: $run/mesh.sock.control
streams:
  - name: box
    synthetic: {scene: moving-box, size: 64x48, fps: 1000, frames: 20, parts: 16}
    mesh: {sigma: [0.002, 0, 0]}
    record: {path: $run/parts.mcap}
YAML
start_dexeld -c parts.yaml || exit 1
want=$("$dexel" cat --socket mesh.sock --stats --quiet | sed 's/.*"digest": "\([0-9a-f]*\)".*/\1/')
stop_dexeld || fail 'dexeld failed'
same 'parts of a simulated stream' "$want" "$(mesh parts.mcap --sigma 0.002)"
expect 0 "$dexel" info parts.mcap --json
tells '"frames": 20'
expect 0 "$dexel" convert parts.mcap copy.mcap
"$B/tests/record_check" copy.mcap >out 2>&1
tells '^blocks 80 first 0 last 79 lost 0 damages 0'
same 'a copy of parts' "$want" "$(mesh copy.mcap --sigma 0.002)"

# ---- clouds: the points of PCD, in the tools and in the service; recorded again, too
for options in '' '--exact'; do
  rm -rf clouds.pcd.d
  # shellcheck disable=SC2086 # words
  expect 0 "$dexel" convert seq clouds.mcap --ros clouds $options
  # shellcheck disable=SC2086
  expect 0 "$dexel" convert seq pcd --format pcd $options
  want=$(mesh pcd)
  same "clouds $options" "$want" "$(mesh clouds.mcap)"
  same "clouds $options, replayed" "$want" "$(replay_digest clouds.mcap)"
  expect 0 "$dexel" convert clouds.mcap recorded.mcap
  same "clouds $options, recorded" "$want" "$(mesh recorded.mcap)"
  same "clouds $options, recorded and replayed" "$want" "$(replay_digest recorded.mcap)"
  expect 0 "$dexel" convert clouds.mcap back --format pcd --exact
  [ -z "$options" ] || for k in 0 1 2 3; do cmp back/frame-00000$k.pcd pcd/frame-00000$k.pcd || bad=1; done
done
expect 0 "$dexel" convert run.mcap from_recording.mcap --ros clouds
expect 0 "$dexel" convert seq from_scans.mcap --ros clouds
cmp from_recording.mcap from_scans.mcap || fail 'clouds of a recording and of its scans differ'
expect 0 "$dexel" info clouds.mcap --json
for what in '"profile": "ros2"' '"topic": "/dexel/points"' '"schema": "sensor_msgs/msg/PointCloud2"' '"frames": 4'; do
  tells "$what"
done
expect 0 "$dexel" convert seq both.mcap --ros both
expect 0 "$dexel" info both.mcap --json
for what in '"topic": "/dexel/mesh"' '"schema": "foxglove_msgs/msg/SceneUpdate"' '"messages": 8' '"sound": true'; do
  tells "$what"
done
same 'clouds beside meshes' "$want" "$(mesh both.mcap --exact)"

# ---- the gaps that a recording tells of stay in its copy: here behind the header, so its index is wrong
head_len=$((17 + $(od -An -tu8 -j9 -N8 parts.mcap)))
{
  head -c $head_len parts.mcap
  printf '\014\053\0\0\0\0\0\0\0\011\0\0\0dexel.gap\032\0\0\0\006\0\0\0blocks\002\0\0\00012'
  printf '\001\0\0\0a\001\0\0\0b'
  tail -c +$((head_len + 1)) parts.mcap
} >gap.mcap
expect 0 "$dexel" convert gap.mcap copy.mcap
expect 0 "$dexel" info copy.mcap --json
tells '"name": "dexel.gap", "values": \{"blocks": "12"'
expect 0 "$dexel" convert gap.mcap one.mcap --frame 2
expect 0 "$dexel" info one.mcap --json
! grep -q dexel.gap out || fail 'a frame has a gap'

# ---- what cannot be
expect 2 "$dexel" convert seq out.pcd --ros mesh; says "--ros: found 'out.pcd', expected a name ending in .mcap"
expect 2 "$dexel" convert seq out.mcap --format pcd; says "--format: found 'pcd' for the output 'out.mcap'"
expect 2 "$dexel" convert seq out.mcap --topic /foo; says "--topic: found '/foo' for the scans 'seq'"
for options in '--tilt 30' '--ros clouds --tilt 30' '--ros clouds --caps --tilt 30'; do
  # shellcheck disable=SC2086 # words
  expect 2 "$dexel" convert seq out.mcap $options; says 'found without --ros mesh or --ros both'
done
expect 0 "$dexel" convert seq out.mcap --ros mesh --tilt 30
rm out.mcap
expect 2 "$dexel" convert --repair run.mcap -o out.mcap --frame 3 --ros both; says '--repair: found --frame'
expect 2 "$dexel" convert --repair run.mcap -o out.ptx; says "--repair: found -o 'out.ptx'"
[ ! -e out.ptx ] || fail 'a refused repair left something'
expect 2 "$dexel" convert seq out.ply; says 'a name ending in .mcap'
expect 2 "$dexel" convert seq out.mcap --ros none; says "--ros: found 'none', expected clouds|mesh|both"
for options in '--unit 0.001' '--size 20x20' '--exact' '--seam off' '--topic /a'; do
  # shellcheck disable=SC2086 # words
  expect 2 "$dexel" convert run.mcap none $options; says "for the recording 'run.mcap', expected none"
  # shellcheck disable=SC2086
  expect 2 "$dexel" mesh run.mcap --stats $options; says "for the recording 'run.mcap', expected none"
done
expect 1 "$dexel" mesh clouds.mcap --topic /other --stats
says "clouds.mcap: found no sensor_msgs/msg/PointCloud2 on topic '/other', but on /dexel/points"
expect 0 "$dexel" mesh clouds.mcap --topic /dexel/points --stats
expect 0 "$dexel" convert seq mesh.mcap --ros mesh
expect 1 "$dexel" mesh mesh.mcap --stats; says 'mesh.mcap'
head -c 3000 hall.ptx >cut.ptx
expect 1 "$dexel" convert cut.ptx out.mcap; says cut.ptx
expect 1 "$dexel" convert cut.ptx out.mcap --ros both; says cut.ptx
[ ! -e out.mcap ] && [ ! -e none ] || fail 'a failed conversion left something'
n_files=$(find . | wc -l)
(ulimit -f 16; expect 1 "$dexel" convert seq full.mcap; says 'full.mcap: cannot be written'; exit $bad) || bad=1
(ulimit -f 16; expect 1 "$dexel" convert seq full.mcap --ros both; says 'full.mcap: cannot be written'; exit $bad) || bad=1
[ "$(find . | wc -l)" = "$n_files" ] || fail 'a failed write left something behind'
head -c $(($(wc -c <clouds.mcap) * 9 / 10)) clouds.mcap >cut.mcap
expect 1 "$dexel" convert cut.mcap out.mcap; says 'cut.mcap: damaged in'
exit $bad
