#!/bin/sh
# Our MCAP files, whole and repaired, read by the official JavaScript library with all CRCs checked, and its files read
# by ours: the same messages, channels, attachments and metadata, line by line. Needs node and npm with its registry;
# says so and skips where they are not. Not part of `make check`:  make peers-mcap
set -eu
B=${B:-build}
skip() { echo "mcap: skipped: $1"; exit 0; }
fail() { echo "mcap: FAILED: $1"; exit 1; }

command -v node >/dev/null && command -v npm >/dev/null || skip "no node or no npm"
js=$B/peers/mcap-js
mkdir -p "$js"
[ -e "$js/package.json" ] || echo '{"name": "mcap-peer", "private": true}' >"$js/package.json"
if [ ! -d "$js/node_modules/@mcap/core" ] || [ ! -d "$js/node_modules/@foxglove/schemas" ] ||
  [ ! -d "$js/node_modules/@foxglove/rosmsg-msgs-common" ]; then
  (cd "$js" && timeout 300 npm install --no-audit --no-fund --ignore-scripts --save-exact @mcap/core@2.2.2 \
    @mcap/support@1.1.0 lz4js@0.2.0 @foxglove/rosmsg@5.0.5 @foxglove/rosmsg2-serialization@3.1.0 \
    @foxglove/schemas@2.1.0 @foxglove/rosmsg-msgs-common@3.2.3 >npm.log 2>&1) || skip "npm could not install @mcap/core: $(tail -n 1 "$js/npm.log")"
fi
cp tests/peers/mcap_peer.mjs tests/peers/mcap_files.mjs tests/peers/mcap_bag.mjs "$js/"
run=$(mktemp -d)
trap 'rm -rf "$run"' EXIT
ours() { "$B/peers/mcap_peer" "$@"; }
theirs() { node "$js/mcap_peer.mjs" "$@"; }
messages() { grep -c '^M' "$1" || true; }

# same NAME FILE list|stream: both sides read the same
same() {
  ours "$3" "$2" >"$run/ours" || fail "$1: our reader"
  theirs "$3" "$2" >"$run/theirs" || fail "$1: their reader"
  cmp -s "$run/ours" "$run/theirs" || fail "$1, $3: $(diff "$run/ours" "$run/theirs" | head -n 3)"
  echo "same  $1, $3: $(messages "$run/ours") messages"
}

echo "-- ours, read by $(node -p "const p = require('$PWD/$js/node_modules/@mcap/core/package.json'); p.name + ' ' + p.version")"
for c in none lz4 zstd; do
  f=$run/$c.mcap
  ours write "$f" $c
  same "$c, whole" "$f" list
  same "$c, whole" "$f" stream
  n=$(messages "$run/ours")
  [ "$n" = 4000 ] || fail "$c: $n messages, expected 4000"
  # cut in a chunk, in a message index, before the end of data, in the footer
  size=$(stat -c %s "$f")
  for cut in $((size / 3)) $((size / 2 + 17)) $((size * 9 / 10)) $((size - 30)); do
    head -c "$cut" "$f" >"$run/cut.mcap"
    ours stream "$run/cut.mcap" >"$run/before" 2>/dev/null && fail "$c: a cut at $cut was not noticed"
    "$B/bin/dexel" convert --repair "$run/cut.mcap" -o "$run/fixed.mcap" 2>/dev/null || fail "$c: repair of a cut at $cut"
    same "$c, cut at byte $cut and repaired" "$run/fixed.mcap" list
    same "$c, cut at byte $cut and repaired" "$run/fixed.mcap" stream
    grep '^M' "$run/before" >"$run/a"
    grep '^M' "$run/theirs" >"$run/b"
    cmp -s "$run/a" "$run/b" || fail "$c: the repaired file has other messages than the cut one"
  done
  # 100000 bytes of zeros in the middle
  dd if=/dev/zero of="$f" bs=1000 seek=2000 count=100 conv=notrunc 2>/dev/null
  "$B/bin/dexel" convert --repair "$f" -o "$run/fixed.mcap" 2>/dev/null || fail "$c: repair of a hole"
  same "$c, with a hole and repaired" "$run/fixed.mcap" list
done

echo "-- a cloud, decoded by @foxglove/rosmsg2-serialization with the schema in the file"
ours cloud "$run/cloud.mcap"
theirs ros "$run/cloud.mcap" >"$run/theirs" || fail "cloud: their decoder"
cloud='scanner 1700000000.500000000 2x3 step 14 42 big false dense false
x:0:7:1 y:4:7:1 z:8:7:1 intensity:12:4:1
0 0 0.5 0
0 1 0.5 1000
0 2 0.5 2000
1 0 0.5 3000
1 1 0.5 4000
NaN NaN NaN 5000'
printf '%s\n%s\n' "$cloud" "$cloud" >"$run/ours"
cmp -s "$run/ours" "$run/theirs" || fail "cloud: $(diff "$run/ours" "$run/theirs" | head -n 5)"
echo "same  2 clouds"

echo "-- a mesh, and a conversion, decoded by it as well; their schema beside what @foxglove/schemas publishes"
ours scene "$run/scene.mcap"
theirs ros "$run/scene.mcap" >"$run/theirs" || fail "scene: their decoder"
cat >"$run/ours" <<'EOT'
delete 1700000000.500000000 1 ''
entity 1700000000.500000000 scanner mesh/7 for 0.0 locked false others 00000000
at 0.5 -1 2, 0 0 0 1
0 0 0.5
1 0 0.5
0 1 0.5
1 1 0.25
color 0 0.5 1 1
1 0 0 1
0 1 0 1
0 0 1 0.5
1 1 1 1
indices 0 1 2 2 1 3
entity 1700000000.500000000 scanner mesh/8 for 0.0 locked false others 00000000
at 0.5 -1 2, 0 0 0 1
0 0 0.5
1 0 0.5
0 1 0.5
1 1 0.25
color 0 0.5 1 1
indices 0 1 2 2 1 3
delete 1700000000.500000000 1 ''
EOT
cmp -s "$run/ours" "$run/theirs" || fail "scene: $(diff "$run/ours" "$run/theirs" | head -n 5)"
echo "same  2 scenes and one of nothing"

# A conversion: the points of its clouds are those of PCD, the vertices of its meshes those of PLY.
"$B/bin/dexel" sim hall -o "$run/hall.pcd" --size 60x40 --noise 0.004 --dropouts 0.02 --attr 16
"$B/bin/dexel" convert "$run/hall.pcd" "$run/both.mcap" --ros both
"$B/bin/dexel" convert "$run/hall.pcd" "$run/one.pcd"
"$B/bin/dexel" mesh "$run/hall.pcd" -o "$run/one.ply"
theirs schema "$run/both.mcap" >"$run/types" || fail "schema: not as published"
grep -q '^foxglove_msgs/msg/SceneUpdate 17 types$' "$run/types" || fail "schema: $(cat "$run/types")"
theirs ros "$run/both.mcap" >"$run/theirs" || fail "both: their decoder"
node "$js/mcap_files.mjs" "$run/one.pcd" "$run/one.ply" >"$run/ours"
cmp -s "$run/ours" "$run/theirs" || fail "both: $(diff "$run/ours" "$run/theirs" | head -n 5)"
echo "same  a cloud of 60x40 and its mesh of $(grep -c . "$run/theirs") lines, and all types of the schema"

echo "-- theirs, read by us"
for c in none lz4 zstd; do
  for how in "" norepeat nochunks noindex nosummary "nosummary nochunks" unknown "unknown nochunks"; do
    f=$run/theirs.mcap
    # shellcheck disable=SC2086 # words
    theirs write "$f" $c $how
    case $how in "" ) same "$c" "$f" list ;; esac
    # all orders are told apart: in the file's order here
    same "$c${how:+, $how}" "$f" stream
    # and by log time they are the same messages, sorted
    ours list "$f" | grep '^M' >"$run/a" || fail "$c, $how: by log time"
    grep '^M' "$run/theirs" | sort -s -n -k 4,4 >"$run/b"
    cmp -s "$run/a" "$run/b" || fail "$c, $how: order of log time: $(diff "$run/a" "$run/b" | head -n 3)"
    [ "$(wc -l <"$run/a")" = 3000 ] || fail "$c, $how: $(wc -l <"$run/a") messages, expected 3000"
  done
done

echo "-- their clouds, read by us"
node "$js/mcap_bag.mjs" "$run/one.pcd" "$run/bag.mcap" || fail "bag: their writer"
for topic in /packed /padded; do
  rm -rf "$run/bag"
  "$B/bin/dexel" convert "$run/bag.mcap" "$run/bag" --format pcd --topic $topic --exact || fail "bag: $topic"
  for k in 0 1 2; do
    cmp "$run/bag/frame-00000$k.pcd" "$run/one.pcd" || fail "bag: $topic, frame $k"
  done
  echo "same  3 clouds of $topic"
done
echo "mcap: all the same"
