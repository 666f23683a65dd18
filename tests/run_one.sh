#!/bin/sh
# One test of tests/run.sh: run_one.sh LOG_FOLDER TEST. Tells how it ended in one write, so that tests at the same time do
# not mix their lines; the seconds that it took are in the folder's NAME.seconds.
set -u
log=$1 test=$2
name=$(basename "$test" .sh)
begun=$(date +%s)

case $test in
  *.sh) timeout 1200 sh "$test" ;; # compilers.sh builds all of it three times
  *) timeout 600 "$test" ;;
esac >"$log/$name.log" 2>&1 </dev/null
status=$?
echo $(($(date +%s) - begun)) >"$log/$name.seconds"

case $status in
  0) echo "pass  $name" ;;
  77) echo "skip  $name: $(tail -n 1 "$log/$name.log")" ;;
  *) printf '%s\n' "FAIL  $name
$(tail -n 40 "$log/$name.log" | sed 's/^/      /')" ;;
esac
