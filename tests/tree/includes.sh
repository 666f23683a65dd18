#!/bin/sh
# The include rule: who may include whom (CONTRIBUTING.md), which external headers belong to one room
# only, and file names unique in the tree. Prints each breach; exits 1 when there is one.
set -u
bad=0
breach() { echo "$1"; bad=1; }

# rule FOLDER 'regex of project headers allowed in it'
rule() {
  grep -nE '^#include "' $(git ls-files --cached --others --exclude-standard "$1/*.c" "$1/*.h") /dev/null |
    grep -vE "#include \"($2)" > "${TMPDIR:-/tmp}/includes.$$" || true
  [ ! -s "${TMPDIR:-/tmp}/includes.$$" ] || breach "$(sed "s|^|$1 may not include: |" "${TMPDIR:-/tmp}/includes.$$")"
  rm -f "${TMPDIR:-/tmp}/includes.$$"
}
rule core/base 'core/base/'
rule core/rows 'core/(base|rows)/'
rule core/grid 'core/(base|rows|grid)/'
rule core/cloud 'core/(base|cloud)/'
rule core/wire 'core/(base|rows|grid|wire)/'
rule drivers '(core|drivers)/'
rule client 'client/|core/(wire|base)/|core/grid/(geometry|tile|plane|octahedral).h'
rule daemon '(core|drivers|daemon)/'
rule tools 'client/|core/|tools/|drivers/(driver.h|replay.h|file|synth)|daemon/config.h'

# A configuration is read and printed in one place, for the service and for the tools: it knows nothing of the service.
hits=$(grep -nE '^#include "' daemon/config*.[ch] | grep -vE '#include "(core/|drivers/|daemon/config|daemon/record_files.h)')
[ -z "$hits" ] || breach "daemon/config* may not include: $hits"

# Siblings do not know each other: a driver's folder includes itself and drivers/*.h only.
# drivers/usb is their common way to libusb.
families='file synth v4l2 hokuyo kinect gpio'
for d in $families; do
  for other in $families; do
    [ "$d" != "$other" ] && [ -d "drivers/$d" ] && grep -rnE "#include \"drivers/$other/" "drivers/$d" && breach "drivers/$d includes drivers/$other"
  done
done

# core: no sockets, no clock, no exit; stdio in err.c (vsnprintf) and pthread in pool.c only.
for h in 'sys/socket.h' 'time.h' 'stdio.h' 'pthread.h' 'fcntl.h'; do
  hits=$(grep -rln "#include <$h>" core | grep -vE '^core/base/(err|pool)\.c$')
  [ -z "$hits" ] || breach "core may not include <$h>: $hits"
done
hits=$(grep -rnE '\b(exit|abort|sin|cos|tan|atan2|acos|exp|log|pow)\(' core --include='*.c' --include='*.h' | grep -vE '^\S+:[0-9]+:\s*(\*|/\*)')
[ -z "$hits" ] || breach "core may not call: $hits"

# Each external library is included by one room only.
room() { # header-regex allowed-regex
  hits=$(grep -rlE "#include <$1" core drivers client daemon tools | grep -vE "^($2)")
  [ -z "$hits" ] || breach "<$1> belongs to $2 only: $hits"
}
room 'yaml.h' 'daemon/config'
room 'png.h' 'tools/out_png.c'
room 'lzf.h|liblzf' 'drivers/file/in_pcd'
room 'zlib.h' 'drivers/file/(slurp|crc32).c'
room 'zstd.h' 'drivers/file/mcap_zstd.c'
room 'lz4' 'drivers/file/mcap_lz4.c'
room 'jansson.h' 'daemon/(control|status|metrics)|tools/'
room 'systemd/' 'daemon/|drivers/udev.c'
room 'libusb-1.0/' 'drivers/usb/'
room 'gpiod.h' 'drivers/gpio/'
room 'linux/videodev2.h' 'drivers/v4l2/'

twice=$(git ls-files --cached --others --exclude-standard '*.c' '*.h' | xargs -n1 basename | grep -v '^main.c$' | sort | uniq -d)
[ -z "$twice" ] || breach "file names that occur twice: $twice"
exit $bad
