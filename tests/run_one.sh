#!/bin/sh
# One test of tests/run.sh: run_one.sh LOG_FOLDER TEST. Tells how it ended in one write, so that tests at the same time do
# not mix their lines; the seconds that it took are in the folder's NAME.seconds. What a sanitizer reports of any program
# that a test starts makes it fail, whether or not the test looks at how that program ended.
set -u
log=$1 test=$2
name=$(basename "$test" .sh)
begun=$(date +%s)

reports=$(cd "$log" && pwd)/$name.report
rm -f "$reports".*
REPORT=$reports # tests/valgrind.sh
export REPORT
# A unit test's own output and status tell. (AddressSanitizer looks for the folder of a log_path before the wrappers of umockdev,
# which some link, are ready for it.)
case $test in
  *.sh)
    ASAN_OPTIONS=${ASAN_OPTIONS:+$ASAN_OPTIONS:}log_path=$reports
    UBSAN_OPTIONS=${UBSAN_OPTIONS:+$UBSAN_OPTIONS:}log_path=$reports:print_stacktrace=1
    LSAN_OPTIONS=${LSAN_OPTIONS:+$LSAN_OPTIONS:}print_suppressions=0
    TSAN_OPTIONS=${TSAN_OPTIONS:+$TSAN_OPTIONS:}log_path=$reports
    export ASAN_OPTIONS UBSAN_OPTIONS LSAN_OPTIONS TSAN_OPTIONS
    ;;
esac

# Against hanging alone.
case $test in
  *.sh) timeout "${TEST_SECONDS:-1200}" sh "$test" ;; # compilers.sh builds all of it three times
  *) timeout "${TEST_SECONDS:-600}" "$test" ;;
esac >"$log/$name.log" 2>&1 </dev/null
status=$?
echo $(($(date +%s) - begun)) >"$log/$name.seconds"
for report in "$reports".*; do
  [ -s "$report" ] || continue
  # valgrind tells of descriptors that a program was given
  sed -e '/FILE DESCRIPTORS: /d; /^==[0-9]*== $/d; /== Open .*[0-9]:/{N; /<inherited from parent>/d}' "$report" >"$report.own"
  [ -s "$report.own" ] || continue
  cat "$report.own" >>"$log/$name.log"
  status=1
done

case $status in
  0) echo "pass  $name" ;;
  77) echo "skip  $name: $(tail -n 1 "$log/$name.log")" ;;
  *) printf '%s\n' "FAIL  $name
$(tail -n 40 "$log/$name.log" | sed 's/^/      /')" ;;
esac
