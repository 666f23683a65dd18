# Two scanners on USB, one on xhci (redir_scip.c) and one of the kernel's gadgets on dummy_hcd, and two streams that name
# their serial numbers: each gets its own, at the start and when both have been out and one of them came back first.
# limit: 300
set -eu
. tests/daemon.sh
. tests/hil/devices.sh

modprobe xhci-pci
load_scip_gadget
scip_scanner --serial H0000002 --rpm 0
scip_stream 'serial: H0614967'
sed -i 's/rpm: 6/rpm: 30/' "$run/dexeld.yaml"
sed -n '/- name/,$p' "$run/dexeld.yaml" | sed 's/name: turret/name: other/;s/H0614967/H0000002/' >"$run/other"
cat "$run/other" >>"$run/dexeld.yaml"

# n_are N STATE: so many of the two devices
n_are() { [ "$(status | grep -o '"device":{[^}]*"state":"'"$2"'"' | wc -l)" = "$1" ]; }
# each_its_own: the serials in the order of the streams
each_its_own() {
  await 90 n_are 2 streaming
  serials=$(status | grep -o '"serial":"[^"]*"' | tr -d '\n')
  [ "$serials" = '"serial":"H0614967""serial":"H0000002"' ] || wrong "$serials"
}

plug_scip
scanner plug
start_dexeld -c "$run/dexeld.yaml"
each_its_own
unplug_scip
scanner unplug
await 30 n_are 2 gone
plug_scip
await 90 n_are 1 streaming
scanner plug
each_its_own
status
stop_dexeld
scanner unplug
unplug_scip
unload_scip_gadget
