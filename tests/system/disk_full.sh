#!/bin/sh
# A full disk, and a limit on the size of files: every command says so, ends with status 1, and leaves neither half a
# file nor a temporary one; a file that was there before stays.
set -u
. tests/daemon.sh
[ -w /dev/full ] || { echo "no /dev/full"; exit 77; }
dexel=$B/bin/dexel
bad=0
wrong() { echo "wrong: $*"; bad=1; }

"$dexel" sim sphere -o "$run/scan.pcd" --size 200x150 --noise 0.001 || exit 1
for e in ply obj stl ptx pcd png; do ln -s /dev/full "$run/full.$e"; done
start_dexeld --replay "$run/scan.pcd" --wait 1 --socket "$run/mesh.sock" || exit 1

# told FILE COMMAND...: status 1, and the message names FILE; the folder is as before
told() {
  file=$1
  shift
  ls -A "$run" >"$run/.before"
  code=0
  timeout 300 "$@" >"$run/.out" 2>"$run/.said" || code=$?
  [ $code = 1 ] || wrong "$*: status $code, expected 1: $(cat "$run/.said")"
  grep -qE "$file: .*(No space left|File too large)" "$run/.said" || wrong "$*: said '$(cat "$run/.said")'"
  ls -A "$run" | cmp -s - "$run/.before" || wrong "$*: left $(ls -A "$run")"
}
touch "$run/.before" "$run/.out" "$run/.said"

for e in ply obj stl; do
  told "full.$e" "$dexel" mesh "$run/scan.pcd" -o "$run/full.$e"
  told "full.$e" "$dexel" cat --socket "$run/mesh.sock" --quiet -o "$run/full.$e"
done
told full.ptx "$dexel" convert "$run/scan.pcd" "$run/full.ptx"
told full.pcd "$dexel" sim hall -o "$run/full.pcd" --size 200x150
told full.png "$dexel" render "$run/scan.pcd" -o "$run/full.png"

# 16 KiB, or 32 blocks of 512 bytes: less than any of these files
cat >"$run/limited" <<'EOF'
#!/bin/sh
ulimit -f 32 && exec "$@"
EOF
chmod +x "$run/limited"
echo precious >"$run/there.ply"
told new.ply "$run/limited" "$dexel" mesh "$run/scan.pcd" -o "$run/new.ply"
told there.ply "$run/limited" "$dexel" mesh "$run/scan.pcd" -o "$run/there.ply"
told there.ply "$run/limited" "$dexel" cat --socket "$run/mesh.sock" --quiet -o "$run/there.ply"
told new.ptx "$run/limited" "$dexel" convert "$run/scan.pcd" "$run/new.ptx"
told new.pcd "$run/limited" "$dexel" sim hall -o "$run/new.pcd" --size 200x150
told new.png "$run/limited" "$dexel" render "$run/scan.pcd" -o "$run/new.png"
[ "$(cat "$run/there.ply")" = precious ] || wrong "a file that was there is gone"

# standard output
for command in "mesh $run/scan.pcd --stats" "cat --socket $run/mesh.sock --quiet --stats" \
  "status --socket $run/mesh.sock --json" "status --socket $run/mesh.sock" "metrics --socket $run/mesh.sock" \
  "config --socket $run/mesh.sock" "config --socket $run/mesh.sock --json" \
  "doctor --socket $run/mesh.sock" "doctor --json" "info --json $run/scan.pcd" \
  "sim --list" --version --help help "help cat" "bench copy --size 64x64 --rounds 1"; do
  code=0
  # shellcheck disable=SC2086 # words
  timeout 300 "$dexel" $command >/dev/full 2>"$run/.said" || code=$?
  [ $code = 1 ] || wrong "dexel $command: status $code, expected 1"
  grep -qx "dexel: standard output: No space left on device" "$run/.said" ||
    wrong "dexel $command: said '$(cat "$run/.said")'"
done
"$dexel" mesh "$run/scan.pcd" -o "$run/none.ply" >/dev/full || wrong "mesh, which prints nothing: status $?"
cat >"$run/c.yaml" <<'EOF'
streams: [{name: s, synthetic: {scene: hall}}]
EOF
for options in "-c $run/c.yaml --check" --version --help; do
  code=0
  # shellcheck disable=SC2086 # words
  "$B/bin/dexeld" $options >/dev/full 2>"$run/.said" || code=$?
  [ $code = 1 ] && grep -qx "dexeld: standard output: No space left on device" "$run/.said" ||
    wrong "dexeld $options: status $code, said '$(cat "$run/.said")'"
done
stop_dexeld || wrong "dexeld: status $dexeld_status"
exit $bad
