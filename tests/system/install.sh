#!/bin/sh
# make install: the example client is built against what was installed, with pkg-config alone, and runs against the
# installed service. make uninstall leaves nothing but the configuration.
set -eu
. tests/daemon.sh
"$B/tests/sanitized" || { echo "a sanitizer's library is not to be installed"; exit 77; }
root=$run/root
wrong() { echo "$1"; exit 1; }
built=$B
at_root() { make -s --no-print-directory B="$built" DESTDIR="$root" prefix=/usr sysconfdir=/etc "$1"; }

at_root install
for f in bin/dexel sbin/dexeld include/dexel.h lib/libdexel.a lib/pkgconfig/libdexel.pc share/man/man1/dexel.1 share/man/man1/dexel-mesh.1 \
  share/man/man5/dexeld.yaml.5 share/man/man8/dexeld.8 share/doc/dexeld/protocol.md \
  share/dexeld/grafana/dexeld.json share/dexeld/prometheus/dexeld.rules.yml \
  share/doc/dexeld/hall.png share/doc/dexeld/follow.c lib/sysusers.d/dexeld.conf lib/tmpfiles.d/dexeld.conf \
  lib/systemd/system/dexeld.service lib/systemd/system/dexeld.socket lib/python3/dist-packages/dexel.py \
  share/bash-completion/completions/dexel share/bash-completion/completions/dexeld; do
  [ -f "$root/usr/$f" ] || wrong "no /usr/$f"
done
! grep -rn /usr/local "$root/usr/share/man" || wrong "a manual page names another prefix"
export PKG_CONFIG_PATH="$root/usr/lib/pkgconfig" PKG_CONFIG_SYSROOT_DIR="$root"
grep -qx 'prefix=/usr' "$root/usr/lib/pkgconfig/libdexel.pc" || wrong "libdexel.pc: $(cat "$root/usr/lib/pkgconfig/libdexel.pc")"
[ "$(pkg-config --modversion libdexel)" = "$("$root/usr/bin/dexel" --version | cut -d' ' -f2)" ] || wrong "libdexel.pc: another version"

# /usr is a folder that pkg-config leaves out, were it not below another root
export PKG_CONFIG_ALLOW_SYSTEM_CFLAGS=1 PKG_CONFIG_ALLOW_SYSTEM_LIBS=1
# shellcheck disable=SC2046 # words
${CC:-cc} -Wall -Wextra -Werror docs/examples/follow.c $(pkg-config --cflags --libs libdexel) -o "$run/follow"
# shellcheck disable=SC2046 # words
${CC:-cc} docs/examples/follow.c $(pkg-config --cflags libdexel) "$root/usr/lib/libdexel.a" \
  $(pkg-config --static --libs-only-l libdexel | sed 's/-ldexel//') -o "$run/follow-static"
printf '#include <stdlib.h>\n#define calloc(n, size) NULL\n' >"$run/poor.h"
# shellcheck disable=SC2046 # words
${CC:-cc} -include "$run/poor.h" docs/examples/follow.c $(pkg-config --cflags libdexel) "$root/usr/lib/libdexel.a" \
  $(pkg-config --static --libs-only-l libdexel | sed 's/-ldexel//') -o "$run/follow-poor"

"$root/usr/sbin/dexeld" -c "$root/etc/dexeld/dexeld.yaml" --check
"$root/usr/bin/dexel" sim sphere -o "$run/scan.pcd" --size 60x40
mkdir "$run/bin"
ln -s "$root/usr/sbin/dexeld" "$run/bin/dexeld" # where start_dexeld looks for it
B=$run
for follow in follow follow-static; do # it is there before the service, and says that it waits
  mkfifo "$run/$follow.lines"
  DEXELD_SOCKET=$run/mesh.sock LD_LIBRARY_PATH=$root/usr/lib timeout 300 "$run/$follow" >"$run/$follow.lines" &
  follow_pid=$!
  exec 8<"$run/$follow.lines"
  read -r line <&8 || line='not a word'
  case $line in
  "gone: $run/mesh.sock: No such file or directory") ;;
  *) wrong "$follow: $line" ;;
  esac
  start_dexeld --replay "$run/scan.pcd" --rate max --socket "$run/mesh.sock"
  cat <&8 >"$run/lines"
  wait $follow_pid || wrong "$follow failed"
  grep -q '^replay: 40 x 60 dexels' "$run/lines" || wrong "$follow: $(cat "$run/lines")"
  grep -q '^epoch .*, frame 0: .* tiles changed, [1-9][0-9]* triangles' "$run/lines" || wrong "$follow: $(cat "$run/lines")"
  grep -qx ended "$run/lines" || wrong "$follow: $(cat "$run/lines")"
  stop_dexeld
done
start_dexeld --replay "$run/scan.pcd" --rate max --socket "$run/mesh.sock"
code=0
DEXELD_SOCKET=$run/mesh.sock timeout 300 "$run/follow-poor" 2>"$run/lines" >/dev/null || code=$?
[ $code = 1 ] && grep -qx 'follow: no memory for 1 tiles' "$run/lines" || wrong "without memory: $code, $(cat "$run/lines")"
stop_dexeld

at_root uninstall
left=$(cd "$root" && find . ! -type d)
[ "$left" = ./etc/dexeld/dexeld.yaml ] || wrong "uninstall left: $left"
