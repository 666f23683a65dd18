#!/bin/sh
# The programs under valgrind's memcheck, in system tests, and unit tests; installs valgrind. $B/valgrind has programs of
# the same names that run those of $B under it, so a test need not know; what it reports of any of them makes the test fail
# (run_one.sh). valgrind 3.19 shows a program no AVX-512, so the loops are those for AVX2. The service is one for small
# grids (tests/valgrind/max_tiles_few.c).
#   valgrind.sh [TEST...]    otherwise the list below
set -eu
command -v valgrind >/dev/null || {
  sudo=
  [ "$(id -u)" = 0 ] || sudo=sudo
  DEBIAN_FRONTEND=noninteractive $sudo apt-get install -y --no-install-recommends valgrind >/dev/null
}
from=$(cd "${B:-build}" && pwd)
B=$from/valgrind
export B
rm -rf "$B/bin" "$B/tests" "$B/lib"
mkdir -p "$B/bin" "$B/tests"
ln -s "$from/lib" "$B/lib"

# Descriptors of the service and of unit tests; the tools are killed by scripts, and then have theirs still.
cat >"$B/under" <<END
#!/bin/sh
fds=--track-fds=yes
name=\${0##*/}
case \$name in
  dexel) program=$from/bin/\$name fds= ;;
  dexeld) program=$from/tests/dexeld_few_tiles ;;
  *) program=$from/tests/\$name ;;
esac
exec valgrind --quiet --error-exitcode=99 --leak-check=full --errors-for-leak-kinds=definite,indirect \\
  --show-leak-kinds=definite,indirect \$fds --num-callers=30 \\
  --log-file="\${REPORT:?}.%p" "\$program" "\$@"
END
chmod +x "$B/under"
for program in bin/dexeld bin/dexel; do ln -s ../under "$B/$program"; done
for program in "$from"/tests/*; do
  case $program in
    */test_* | */dexeld_faults) ln -s ../under "$B/tests/${program##*/}" ;;
    *) ln -s "$program" "$B/tests" ;;
  esac
done
ln -sf /bin/false "$B/tests/sanitized" # as slow

# test_feed: each takes a tenth of a second here, and there are 2000 otherwise.
FEED_SEEDS=${FEED_SEEDS:-100}
export FEED_SEEDS

# Not those that mesh large grids, that keep to the end what is stuck or shared (kinect_usb, journal), that count descriptors or
# time, or that umockdev preloads a library into; nor pcd: liblzf's own compressor looks at memory that it has not written.
units='abi args wire chunk chunk_delta feed cdr client client_broken reconnect server server_streams control publish_hold recorder
record_files player reader_device reader_rig config config_errors config_devices config_origin mailbox pool heartbeat
metrics log lifecycle device_status devices file ptx ply_read points ros ros_part ros_scene mcap_read slurp out_mesh
out_frames represent interlock trigger gpio_port hokuyo kinect_depth template_driver pace v4l2_decode cluster cloud
cloud_far cloud_flat cloud_mesh cloud_ring halfedge mesh_split mesh_repair'
[ $# -gt 0 ] || {
  set -- tests/system/reload.sh tests/system/control.sh tests/valgrind/subscribers.sh tests/valgrind/tools.sh
  for name in $units; do set -- "$@" "$B/tests/test_$name"; done
}
exec sh tests/run.sh these "$@"
