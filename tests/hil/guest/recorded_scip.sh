# The scanner on a turning stage recorded by dexeld: the recording replays to the meshes of the live run.
# limit: 400
set -eu
. tests/daemon.sh
. tests/hil/devices.sh

scip_scanner
scip_stream "tty: $run/scip"
recorded
start_dexeld -c "$run/dexeld.yaml"
replays_as_live 3
