#!/bin/sh
# The ways of the tools through small files, for tests/valgrind.sh: what comes out is tested elsewhere.
set -eu
. tests/daemon.sh
B=$(cd "$B" && pwd)
dexel=$B/bin/dexel
cd "$run"

"$dexel" sim moving-box -o scans --format ptx --size 72x66 --noise 0.002 --dropouts 0.01 --frames 2
"$dexel" sim sphere -o ball.pcd --size 40x30
"$dexel" convert scans scans.mcap
"$dexel" convert scans ros.mcap --ros both
"$dexel" convert scans.mcap again --format pcd
head -c 3000 scans.mcap >cut.mcap
"$dexel" convert --repair cut.mcap -o whole.mcap >said 2>&1 || [ $? = 1 ]
for file in scans.mcap ros.mcap scans ball.pcd; do "$dexel" info "$file" >said; done
"$dexel" info --json cut.mcap >said && exit 1
"$dexel" mesh scans -o mesh.ply --normals --caps --smooth --filter median3 --stats >said
"$dexel" mesh scans -o mesh.stl --encoding delta --frame 0
"$dexel" mesh scans -o mesh.obj --encoding q16 --split
"$dexel" mesh scans -o lod.ply --lod 2
for mode in project delaunay smooth; do "$dexel" mesh ball.pcd -o $mode.ply --mode $mode; done
"$dexel" mesh --report mesh.ply >said
"$dexel" mesh --repair project.ply -o mended.ply >said
"$dexel" render mesh.ply -o mesh.png --view iso --size 80x60 --edges
