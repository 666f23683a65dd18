# A simulated SCIP scanner on a pty, on a turning stage, through dexeld: every vertex lies on a wall of its room.
# limit: 120
set -eu
. tests/daemon.sh
. tests/hil/devices.sh

scip_scanner
scip_stream "tty: $run/scip"
start_dexeld -c "$run/dexeld.yaml"
scip_expect 2
status
stop_dexeld
