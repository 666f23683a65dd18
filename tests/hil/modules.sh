#!/bin/sh
# Builds the kernel modules that Debian's kernel does not have, against its headers, and indexes them beside the
# package's own: gpio-sim, and v4l2loopback with the depth format Z16. Again only when this file or the
# kernel has changed.
set -eu
B=${B:-build}
kernel=$B/hil/kernel
stamp=$B/hil/modules.stamp
[ -z "$(find "$stamp" -newer "$kernel/version" -newer tests/hil/modules.sh 2>/dev/null)" ] || exit 0

PATH=$PATH:/sbin:/usr/sbin
release=$(cat "$kernel/version")
headers=$(cd "$kernel/headers" && pwd)
src=$B/hil/modules
rm -rf "$src"
mkdir -p "$src"

# gpio-sim raises its interrupts by irq_sim, which Debian leaves out as well: linked into one module. Of what
# irq_sim calls, irq_to_desc() alone is not exported; generic_handle_irq() does the same.
cp "$kernel/source/drivers/gpio/gpiolib.h" "$src"
cp "$kernel/source/drivers/gpio/gpio-sim.c" "$src/gpio_sim_main.c"
sed 's/handle_simple_irq(irq_to_desc(irqnum));/generic_handle_irq(irqnum);/' \
  "$kernel/source/kernel/irq/irq_sim.c" >"$src/irq_sim.c"

# v4l2loopback passes on listed formats only: Z16 goes in before Y16
cp "$kernel"/loopback/usr/src/v4l2loopback-*/*.[ch] "$src"
sed -i 's/\.fourcc = V4L2_PIX_FMT_Y16,/.fourcc = V4L2_PIX_FMT_Z16, .depth = 16, .flags = 0, }, { .name = "16 bit", &/' \
  "$src/v4l2loopback_formats.h"
grep -q V4L2_PIX_FMT_Z16 "$src/v4l2loopback_formats.h"

cat >"$src/Kbuild" <<'K'
obj-m := gpio-sim.o v4l2loopback.o
gpio-sim-y := gpio_sim_main.o irq_sim.o
K

# the package's Makefile includes another one by its place after installation
makefile=$headers/usr/src/linux-headers-$release/Makefile
sed -i "s|^include .*/usr/src/|include /usr/src/|;s|^include /usr/src/|include $headers/usr/src/|" "$makefile"
log=$B/hil/modules.log
env -u MAKEFLAGS -u MAKELEVEL -u MFLAGS make -C "${makefile%/Makefile}" M="$(cd "$src" && pwd)" modules -j2 \
  >"$log" 2>&1 || { tail -n 20 "$log" >&2; exit 1; }

extra=$kernel/tree/lib/modules/$release/extra
mkdir -p "$extra"
for m in "$src"/*.ko; do strip --strip-debug -o "$extra/${m##*/}" "$m"; done
depmod -b "$kernel/tree" "$release"
touch "$stamp"
