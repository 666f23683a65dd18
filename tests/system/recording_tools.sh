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
