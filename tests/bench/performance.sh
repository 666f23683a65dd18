#!/bin/sh
# Prints docs/performance.md, measured here and now: `make performance`. Takes some ten minutes, and is worth most on
# a machine that has nothing else to do: it tells the load before and after. LARGE=1: clouds of up to ten million points
# and what CGAL does with half a million noisy ones, some twenty minutes more.
set -eu
B=${B:-build}
dexel="$B/bin/dexel"
small=600x400,640x480,2048x128,1280x720,1500x1000

load() { cut -d' ' -f1-3 /proc/loadavg; }
say() { echo "performance: $*" >&2; }

cat <<TEXT
# Performance

Printed by \`make performance\`. All figures are of one run on one machine, and each table was measured in turn, round
by round, so that ratios within a table hold where absolute figures are the machine's of that hour:

- processor: $(sed -n 's/^model name[[:space:]]*: //p' /proc/cpuinfo | head -n 1), $(nproc) in use here, $(awk '/^MemTotal/ {printf "%.0f", $2 / 1048576}' /proc/meminfo) GB of memory
- compiler: $(${CC:-gcc} --version | head -n 1), ${OPT:--O3}
- load average before the run: $(load)

Sizes are columns x rows. Unless a section says otherwise the scan is the simulated hall with 2 mm of noise, by all
default rules, and every tile changes in every frame. Times are medians; those of two threads tell of them only where the
second processor was free. Each section names the command that repeats it.

TEXT

say "stages"
"$dexel" bench --size all --threads 1,2 --markdown
say "rules"
"$dexel" bench rules --size $small --threads 1,2 --markdown
say "updates"
"$dexel" bench update --size $small --threads 1,2 --markdown

say "a service"
cat <<'TEXT'
## A service and its subscribers

The real `dexeld` with the simulated scanner, and `dexel bench live`: all subscribers in one process that counts their
tiles. The service, its simulation and the subscribers share the processors. Latency runs from the stamp of a frame, taken
before it is decoded (here: simulated), to its COMMIT at a subscriber, over all of them; the stages are those of the
service's own histograms, which tell quantiles to an eighth, its first frame and the snapshots' included.
*missed*: epochs that did not come, over all subscribers; *skipped*: frames that the mesher skipped because newer ones were
there; *resets*: subscribers who had to begin anew.

    make bench-live

TEXT
sh tests/bench/live.sh --markdown

say "drivers"
cat <<'TEXT'
## Drivers at their full rate

The service's reader thread with simulated devices. Latency: from the moment at which the last byte of a frame (of a
scan) was there for the driver until the frame (the columns that the stage has left) was in the mailbox; waking the thread
is in it. The processor's share and time are the reader thread's alone. The scanner is behind TCP on this machine; the
Kinect behind a fake of libusb, whose copying of packets counts here; the camera's ioctls are answered in the process. So
the kernel's own part, and a USB bus, are in none of them. *lost*: frames lost or damaged.

    make bench-drivers

TEXT
sh tests/bench/drivers.sh
echo

say "recordings"
TMPDIR=$(test -d /dev/shm && echo /dev/shm || echo "${TMPDIR:-/tmp}") "$dexel" bench record --size 848x480 --markdown

say "the paper's table"
cat <<'TEXT'
## The paper's table

Table 2 of Gopi and Krishnan (2002) on as many samples of a simulated room, thinned to the paper's arrays.

TEXT
"$dexel" bench paper --rounds 3 >"$B/performance.paper"
printf '    dexel bench paper --rounds 3\n\n```\n%s\n```\n\n' "$(cat "$B/performance.paper")"
rm -f "$B/performance.paper"

say "peers"
cat <<'TEXT'
## Beside PCL and VTK

The hall with 1 cm of noise and 2 % drop-outs; the mesh step alone, from ranges or points that are ready in memory.

    make bench-peers ROUNDS=3

TEXT
ROUNDS=${ROUNDS:-3} sh tests/peers/bench_peers.sh --markdown

say "points without an order"
cat <<'TEXT'

## Points without an order

[clouds.md](clouds.md) tells what is computed.

    make bench-clouds            # LARGE=1: up to ten million points

TEXT
LARGE=${LARGE:-} sh tests/bench/clouds.sh --markdown
cat <<'TEXT'

## Points without an order beside CGAL, PCL and Open3D

    make bench-peers-clouds      # LARGE=1: half a million as well

TEXT
LARGE=${LARGE:-} ROUNDS=${ROUNDS:-3} sh tests/peers/bench_peers_clouds.sh --markdown
