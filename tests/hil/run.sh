#!/bin/sh
# Boots the guest and shows what its tests say; exit 0 when all passed.
#   tests/hil/run.sh [TEST...]     all of tests/hil/guest, or those named
#   tests/hil/run.sh --shell       a shell in it instead, on this terminal (Ctrl-A X ends it)
# First serial port: the console, $B/hil/console.log. Second: results. Third and fourth: orders to the USB cameras,
# which are programs on this side (redir_uvc.c, redir_kinect.c); fifth: to the scanner (redir_scip.c).
set -eu
B=${B:-build}
hil=$B/hil
. tests/hil/boot.sh

run=$(mktemp -d)
pids=
at_exit() {
  # shellcheck disable=SC2086 # a list of processes
  [ -z "$pids" ] || kill $pids 2>/dev/null || true
  rm -rf "$run"
}
trap at_exit EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

what="hil_tests=$(echo "$*" | tr ' ' ,) ${HIL_ARGS:-}"
results=stdio
if [ "${1:-}" = --shell ]; then what=hil_shell results=mon:stdio; fi

# camera NAME PROGRAM PORT [SERIAL]: listens at $run/NAME before it returns; can be plugged into the controller's ports PORT and the
# next. SERIAL: QEMU's option for the serial port of its orders, where the machine's own four are taken
devices=
camera() {
  mkfifo "$run/ready"
  "$hil/bin/$2" "$run/$1" "$run/$1.orders" >"$hil/$1.log" 2>&1 3>"$run/ready" &
  pids="$pids $!"
  read -r _ <"$run/ready" || { cat "$hil/$1.log" >&2; exit 1; }
  rm "$run/ready"
  devices="$devices -chardev socket,id=$1,path=$run/$1 -device usb-redir,chardev=$1,bus=usb.0,port=$3
    -chardev socket,id=$1-other,path=$run/$1 -device usb-redir,chardev=$1-other,bus=usb.0,port=$(($3 + 1))
    -chardev socket,id=$1-orders,path=$run/$1.orders ${4:--serial chardev:$1-orders}"
}

guest() {
  # shellcheck disable=SC2086 # a list of arguments
  qemu "8250.nr_uarts=5 $what" -smp "${HIL_CPUS:-1}" -m 768 -initrd "$hil/guest.cpio" -serial "file:$hil/console.log" -serial "$results" $devices
}

devices="-device qemu-xhci,id=usb,p2=8"
camera camera redir_uvc 1
camera kinect redir_kinect 3
camera scanner redir_scip 5 '-device pci-serial,chardev=scanner-orders'

if [ "$what" = hil_shell ]; then guest; exit; fi
guest </dev/null | show "$hil"
verdict "$hil"
