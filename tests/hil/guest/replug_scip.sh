# The scanner on USB is pulled out at random bytes, through the kernel's CDC-ACM gadget and usbfs, and plugged into
# either of two buses (replug.sh).
# limit: 600
set -eu
. tests/daemon.sh
. tests/hil/devices.sh
. tests/hil/replug.sh
[ -n "$(word hil_cycles)" ] || cycles=3 # it takes long to start

# scip ORDER: as the cameras' programs take them (orders.c)
bus=0
scip() {
  case $1 in
    where) answer=$(cat $gadget/UDC) && answer=$(($(echo "${answer:--1}" | sed 's/dummy_udc.//') + 1)) ;;
    unplug-after*)
      echo "${1#* }" >"$run/limit"
      kill -USR1 "$(cat "$run/wire")" 2>/dev/null || true ;;
    plug-other) bus=$((1 - bus)) && scip plug ;;
    plug)
      stty -F /dev/ttyGS0 raw -echo
      wire &
      echo dummy_udc.$bus >$gadget/UDC ;;
    unplug)
      rm -f "$run/limit"
      kill "$(cat "$run/wire")" 2>/dev/null || true
      await 10 is_out ;;
  esac
}
# until it is cut: then it is out
wire() {
  acm_wire "$run/scip" /dev/ttyGS0 "$run/limit" &
  echo $! >"$run/wire"
  wait $! || true
  rm -f "$run/limit"
  echo >$gadget/UDC
}
# whole N: the frames before the last of so many are whole. (Where its walls are is turret_usb's: the stage is quick here,
# and for the first seconds of a stay the scanner's clock is known to some milliseconds only.)
whole() {
  enough=$(($(counted frames) + $1))
  [ "$1" = 1 ] || await 60 meshed_enough
}
meshed_enough() { [ "$(counted frames)" -ge "$enough" ]; }

modprobe dummy_hcd num=2
load_scip_gadget
scip_scanner --rpm 30
scip_stream
sed -i 's/rpm: 6/rpm: 30/' "$run/dexeld.yaml"
small_pages
start_dexeld -c "$run/dexeld.yaml"
scip plug
replug scip 40000 whole
stop_dexeld
scip unplug
unload_scip_gadget
