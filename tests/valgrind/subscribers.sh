#!/bin/sh
# Subscribers of each encoding and mode who come and go while a recording is replayed and recorded again, questions and a
# reload between them, and the end by `dexel quit`, for tests/valgrind.sh: what they get is tested elsewhere.
set -eu
. tests/daemon.sh
B=$(cd "$B" && pwd)
dexel=$B/bin/dexel
cd "$run"

"$dexel" sim moving-box -o scans --format pcd --size 72x66 --noise 0.002 --frames 4
"$dexel" convert scans scans.mcap
cat >c.yaml <<END
socket: $run/mesh.sock
control_socket: $run/mesh.sock.control
metrics_file: $run/metrics.prom
streams:
  - name: replay
    file: {path: $run/scans.mcap, rate: 20, loop: yes}
    mesh: {normals: yes}
    record: {path: $run/again-%Y.mcap}
END
start_dexeld -c c.yaml
through() { "$dexel" cat --socket mesh.sock --stream replay --quiet --frames 2 "$@"; }
through --encoding f32 --normals -o f32.ply
"$dexel" cat --socket mesh.sock --stream replay --quiet --encoding q16 & # one who does not say goodbye
gone=$!
through --encoding q16 --pull
through --encoding delta --interval 100
kill $gone
through --lod 2 --pull
for words in 'status' 'status --json' 'metrics' 'clients' 'config' 'log-level debug' 'record status' 'replay pause' 'replay resume'; do
  # shellcheck disable=SC2086 # words
  "$dexel" $words --socket mesh.sock.control >said
done
sed 's/normals: yes/normals: no, tilt: 70/' c.yaml >next.yaml
printf '  - name: box\n    synthetic: {scene: moving-box, size: 66x40, fps: 20}\n' >>next.yaml
mv next.yaml c.yaml
"$dexel" reload --socket mesh.sock.control >said
through --encoding delta
"$dexel" cat --socket mesh.sock --stream box --quiet --frames 2
"$dexel" quit --socket mesh.sock.control
status=0
wait "$dexeld_pid" || status=$?
dexeld_pid=
[ $status = 0 ] || { echo "status $status after quit"; cat dexeld.log; exit 1; }
for file in again-*.mcap; do "$dexel" info "$file" >said; done
