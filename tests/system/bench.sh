#!/bin/sh
# dexel bench at tiny sizes: every table has its rows and its figures, in JSON, as text and as Markdown; a service is
# measured at its subscribers; what is asked wrongly is refused with words. No figure is compared with another.
set -u
. "$(dirname "$0")/../expect.sh"

# values KEY: its numbers in out, one a line
values() { grep -o "\"$1\": [-0-9.e+]*" out | sed 's/.*: //'; }
# positive N KEY...: each key has N values, all above 0
positive() {
  n=$1
  shift
  for key in "$@"; do
    values "$key" | awk -v n="$n" '!($1 > 0) {bad = 1} END {exit bad || NR != n}' ||
      fail "expected $n positive values of $key, found: $(values "$key" | tr '\n' ' ')"
  done
}
zero() { # N KEY
  values "$2" | awk -v n="$1" '$1 != 0 {bad = 1} END {exit bad || NR != n}' || fail "$2 is not 0 $1 times"
}

small="--size 200x140,130x70 --threads 1,2 --rounds 3"

# shellcheck disable=SC2086 # a list of words
expect 0 "$dexel" bench --json $small
positive 4 publish_ns codes_ns f32_ns q16_ns delta_ns f32_bytes q16_bytes delta_bytes f32_triangles \
  f32_ms q16_ms delta_ms copy_gb_per_s f32_copy_percent q16_copy_percent delta_copy_percent
zero 4 allocations
positive 2 resident_bytes
[ "$(grep -o '"size": "[^"]*"' out | sort | uniq -c | awk '{printf "%s", $1}')" = 44 ] || fail 'not four rows of each size'

# What is not wanted is not measured; ranges of four bytes have no q16.
expect 0 "$dexel" bench --json --size 130x70 --rounds 1 f32
positive 1 f32_ns f32_ms
[ -z "$(values q16_ns)$(values delta_ms)$(values copy_gb_per_s)" ] || fail 'measured what was not asked for'
expect 0 "$dexel" bench --json --size 130x70 --rounds 1 --scene open q16 delta
positive 1 delta_ns
[ -z "$(values q16_ns)" ] || fail 'q16 of four-byte ranges'

# shellcheck disable=SC2086 # a list of words
expect 0 "$dexel" bench rules --json $small
positive 4 first_ns rescue_ns mixed_ns bend_ns bridge_ns normals_ns caps_ns

# Recordings in each compression, and the programs beside; the one that does not compress holds all bytes.
expect 0 "$dexel" bench record --json --size 640x480 --rounds 1
positive "$(values percent | wc -l)" write_gb_per_s read_gb_per_s
values percent | awk 'NR == 1 && $1 < 100 {exit 1} END {exit NR < 4}' || fail "shares: $(values percent | tr '\n' ' ')"

# 7 x 5 tiles of 420x300: a fifth are seven.
expect 0 "$dexel" bench update --json --size 420x300 --dirty 0.2 --rounds 3
positive 1 f32_ms f32_full_ms f32_percent q16_percent delta_percent
[ "$(values tiles) $(values changed)" = "35 7" ] || fail "$(values changed) of $(values tiles) tiles changed, expected 7 of 35"
expect 0 "$dexel" bench update --json --size 420x300 --dirty 0 --rounds 1
[ "$(values changed)" = 1 ] || fail "$(values changed) tiles changed, expected one at the least"

for command in "bench" "bench rules" "bench update"; do
  # shellcheck disable=SC2086 # words
  expect 0 "$dexel" $command --size 130x70 --rounds 1
  grep -q '^ *size  threads ' out && grep -q '^ *130x70 ' out || fail "$command: no table"
  # shellcheck disable=SC2086 # words
  expect 0 "$dexel" $command --size 130x70 --rounds 1 --markdown
  grep -q '^| 130x70 | 1 |' out || fail "$command: no Markdown table"
  grep -q "^    dexel $command --size 130x70 --rounds 1\$" out || fail "$command: does not name what repeats it"
done

# A service at its subscribers. Nothing is said of how many frames come in time.
cat >live.yaml <<Y
socket: $run/mesh.sock
control_socket: $run/control.sock
streams:
  - name: box
    synthetic: {scene: moving-box, size: 160x120, noise: 0.003, fps: 20}
Y
start_dexeld -c live.yaml || exit 1
for encoding in f32 q16 delta; do
  expect 0 "$dexel" bench live --socket mesh.sock --control control.sock --subscribers 1,3 --seconds 0.3 \
    --encoding $encoding --decode --json
  positive 2 epochs_per_s tiles_percent mb_per_s max_ms
  grep -q "\"encoding\": \"$encoding\"" out || fail 'another encoding'
  for stage in decode wait mesh encode send 'all, to the kernel' 'all, at subscribers'; do
    [ "$(grep -o "\"stage\": \"$stage\"" out | wc -l)" = 2 ] || fail "stage $stage is not there twice"
  done
done
expect 0 "$dexel" bench live --socket mesh.sock --stream box --seconds 0.3
grep -q '^ *1 *delta ' out || fail 'bench live: no table'
expect 1 "$dexel" bench live --socket mesh.sock --stream tree --seconds 0.3
says 'dexel bench live: subscriber 1: '
expect 1 "$dexel" bench live --socket mesh.sock --control none.sock --seconds 0.2
says 'none.sock: no dexeld answers here'
stop_dexeld || fail 'the service ended badly'
expect 1 "$dexel" bench live --socket none.sock
says 'dexel bench live: subscriber 1: '

refused() { # TEXT ARGUMENTS...
  text=$1
  shift
  expect 2 "$dexel" bench "$@"
  says "$text"
}
refused "dexel bench: found 'more', expected a benchmark (" more
refused "dexel bench: --size: found '65535x65535', expected at most 67108864 dexels" --size 65535x65535
refused "dexel bench: --size: found '4x4', expected at least 8x2" --size 4x4
refused "dexel bench: --size: found '', expected" --size 100x100,
refused "dexel bench: --threads: found '1,2,3,4,5', expected a list of at most 4" --threads 1,2,3,4,5
refused "dexel bench: --rounds: found '0', expected rounds from 1" --rounds 0
refused "dexel bench: found --dirty, expected it with" --dirty 0.1
refused "dexel bench rules: found 'codes', expected options alone" rules codes
refused "dexel bench update: --dirty: found '2', expected a share from 0 to 1" update --dirty 2
refused "dexel bench live: --subscribers: found '0', expected subscribers from 1" live --subscribers 5,0
refused "dexel bench live: --encoding: found 'png', expected f32|q16|delta" live --encoding png
for command in "" rules update live paper quality; do
  # shellcheck disable=SC2086 # none or one
  expect 0 "$dexel" bench $command --help
  grep -q "^usage: dexel bench" out || fail "bench $command has no help"
done
exit $bad
