# Sourced by scripts that look at a service with a configuration of its own ($yaml, whose socket is $sock). What is wrong is told, and
# $bad is 1 then: they look on, and exit with it.
. tests/daemon.sh
dexel=$B/bin/dexel
yaml=$run/dexeld.yaml
sock=$run/mesh.sock
bad=0
wrong() { echo "wrong: $*"; bad=1; }
