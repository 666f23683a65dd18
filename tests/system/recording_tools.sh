#!/bin/sh
# dexel info and dexel convert --repair: what they tell, their exit status, and what they leave behind. The
# recordings are the seeds of fuzz_mcap.
set -u
dexel=$(cd "${B:-build}/bin" && pwd)/dexel
seeds=$(pwd)/tests/fuzz/corpus/mcap
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
cd "$dir" || exit 1
bad=0

expect() { # STATUS COMMAND...: output in out and err
  want=$1
  shift
  "$@" >out 2>err
  got=$?
  [ "$got" = "$want" ] || { echo "$*: status $got, expected $want"; cat err; bad=1; }
}
says() { grep -qE -- "$1" "$2" || { echo "expected '$1' in $2, found: $(cat "$2")"; bad=1; }; }

# whole recordings
for c in none lz4 zstd; do
  expect 0 "$dexel" info "$seeds/$c.mcap" --json
  for what in '"format": "MCAP"' '"messages": 8' '"sound": true' '"checked": true' '"topic": "/1"' '"topic": "/4"' \
    '"schema": "pkg/msg/Thing"' '"name": "m", "values": \{"key": "value"\}' '"name": "a", "media_type": "text/plain", "bytes": 5'; do
    says "$what" out
  done
  expect 0 "$dexel" info "$seeds/$c.mcap"
  says '^sound +yes$' out
  says '^messages +8$' out
  expect 0 "$dexel" info --quick "$seeds/$c.mcap"
  says '^checked +no$' out
  says '^sound +not checked$' out
done
expect 0 "$dexel" info "$seeds/zstd.mcap"
says '^chunks zstd +[1-9]' out

# gaps: the stamps of a channel are at most 20 ns apart
says '^  gaps +0$' out
says '^  longest gap s +[12]e-08$' out
expect 0 "$dexel" info "$seeds/zstd.mcap" --gap 0.000000005
says '^  gaps +[1-9]$' out

# damaged: told, status 1, and repaired
expect 1 "$dexel" info "$seeds/zstd-cut.mcap" --json
says '"sound": false' out
says '"offset": [0-9]+, "bytes": [0-9]+, "text": "no whole record' out
for c in none lz4 zstd; do
  expect 0 "$dexel" convert --repair "$seeds/$c-cut.mcap" -o fixed.mcap
  says "$c-cut.mcap: byte [0-9]+, [0-9]+ bytes: " err
  says "saved [1-9][0-9]* messages" err
  expect 0 "$dexel" info fixed.mcap
  says 'library +dexeld .* repaired' out
  expect 0 "$dexel" convert --repair fixed.mcap again.mcap
  says '0 damaged places' err
  rm fixed.mcap again.mcap
done

# scans
expect 0 "$dexel" sim hall -o a.ptx --size 60x40 --frames 2 --dropouts 0.25
expect 0 "$dexel" info a.ptx --json
says '"format": "PTX", "frames": 2, "geometry": "spinning", "width": 60, "height": 40' out
says '"valid": 0\.[67]' out
says '"sound": true' out
head -c 3000 a.ptx >cut.ptx
expect 1 "$dexel" info cut.ptx
says '^  text .*cut.ptx' out
mkdir seq && cp a.ptx seq/0.ptx && cp cut.ptx seq/1.ptx
expect 1 "$dexel" info seq --json
says '"frames": 2' out
says '"damaged": 1' out

# a folder of recordings: of each file what is damaged, and times, gaps and frames over all
expect 0 "$dexel" sim moving-box -o box --size 40x30 --frames 8 --format pcd
expect 0 "$dexel" convert box box.mcap
expect 0 "$dexel" info box.mcap --json
says '"exact_points": false' out
expect 0 "$dexel" convert box exact.mcap --exact
expect 0 "$dexel" info exact.mcap --json
says '"exact_points": true' out
mkdir many && cp box.mcap many/0.mcap && cp box.mcap many/1.mcap
expect 0 "$dexel" info many --json
for what in '"files": 2' '"frames": 16' '"messages": 16' '"end_ns": 700000000' '"gaps": 0' '"sound": true, "damaged": 0'; do
  says "$what" out
done
expect 0 "$dexel" info many --json --gap 0.05
says '"gaps": 14' out
expect 0 "$dexel" info many --quick
says '^sound +not checked$' out
LC_ALL=C sed 's/seam_closed/seam_cloned/; s/streams:/streamz:/' box.mcap >many/2.mcap
head -c 100 box.mcap >many/3.mcap
head -c 5 box.mcap >many/4.mcap
head -c $(($(wc -c <box.mcap) - 40)) box.mcap >many/5.mcap
for k in 2 3 5; do
  expect 1 "$dexel" info many/$k.mcap
done
expect 1 "$dexel" info many --json
for k in 0 1; do
  says "\"many/$k.mcap\", [^}]*\"sound\": true" out
done
for k in 2 3 4 5; do
  says "\"file\": \"many/$k.mcap\", \"damaged\": [1-9][0-9]*, \"offset\": [0-9]+, \"bytes\": [0-9]+, \"text\": \"." out
done
says '"sound": false, "damaged": [4-9]' out
says '"frames": 24, "sound": false' out # 2.mcap has no configuration
expect 1 "$dexel" info many
says '^  file +many/2.mcap$' out
says 'attachment: wrong CRC' out
expect 1 "$dexel" info 'many/[05].mcap'
says '^damage 1$' out
mkdir alone && cp many/3.mcap alone
expect 1 "$dexel" info alone --json
says '"damage": \[\{"file": "alone/3.mcap", "damaged": 1' out
# a name that is no UTF-8, of one that is decoded alone
mkdir odd && cp many/2.mcap odd && cp box.mcap "$(printf 'odd/\377.mcap')"
expect 1 "$dexel" info odd --json
says '"frames": 8, "sound": false' out

# a configuration that nothing decodes, in a file that is whole
expect 1 "$dexel" info many/2.mcap --json
# shellcheck disable=SC2046 # two numbers
set -- $(sed 's/.*"offset": \([0-9]*\), "bytes": \([0-9]*\), "text": "attachment: wrong CRC.*/\1 \2/' out)
cp many/2.mcap bad.mcap
head -c 4 /dev/zero | dd of=bad.mcap bs=1 seek=$(($1 + $2 - 4)) conv=notrunc 2>err || { cat err; bad=1; }
expect 0 "$dexel" convert --repair bad.mcap -o bad_config.mcap
expect 1 "$dexel" info bad_config.mcap --json
says '"not_decoded": ".*dexeld.yaml' out
says '"sound": false, "damaged": 1' out
expect 0 "$dexel" info bad_config.mcap --quick

# recordings beside scans, and what is neither
mkdir mixed && cp box.mcap mixed/b.mcap && cp box/frame-000000.pcd mixed/a.pcd
expect 1 "$dexel" mesh mixed --stats --frame 1; says 'mixed/b.mcap: a recording of dexeld among scans' err
expect 1 "$dexel" info mixed; says 'mixed/b.mcap: a recording of dexeld among scans' out
mv mixed/a.pcd mixed/c.pcd
expect 1 "$dexel" mesh mixed --stats; says 'mixed/c.pcd: a scan among recordings' err
expect 1 "$dexel" info mixed; says 'a scan among recordings' out
expect 0 "$dexel" convert box mesh.mcap --ros mesh
expect 1 "$dexel" mesh mesh.mcap --stats; says 'mesh.mcap: neither a recording of dexeld nor clouds' err
expect 0 "$dexel" mesh box -o box.ply
expect 1 "$dexel" info box.ply; says 'box.ply: a mesh, expected a scan or a recording' err

# what is wrong is told, with the right status, and leaves nothing
ls -A >before
expect 2 "$dexel" info; says 'a file' err
expect 2 "$dexel" info a.ptx --gap never; says "'never'" err
expect 2 "$dexel" info a.ptx --nothing
expect 1 "$dexel" info none.mcap; says 'none.mcap' err
expect 1 "$dexel" convert --repair a.ptx -o x.mcap; says 'a.ptx: byte 0: no MCAP file' err
expect 1 "$dexel" convert --repair none.mcap -o x.mcap; says 'none.mcap' err
expect 1 "$dexel" convert --repair "$seeds/none.mcap" -o none/x.mcap; says 'none/x.mcap' err
expect 2 "$dexel" convert --repair "$seeds/none.mcap"; says 'IN and OUT' err
if [ -w /dev/full ]; then
  ln -s /dev/full full.mcap
  expect 1 "$dexel" convert --repair "$seeds/none.mcap" -o full.mcap
  says 'full.mcap: .*(No space left|cannot be repaired)' err
  rm full.mcap
fi
rm -f out err
ls -A >after
grep -v '^out$\|^err$\|^after$' before >b
grep -v '^out$\|^err$\|^after$\|^b$' after >a
cmp a b || bad=1
exit $bad
