#!/bin/sh
# What the guest must arrive at, made on this side: expected.sh FOLDER
#   hall.sha256     of the mesh of a simulated scene
#   kinect.pixels   what redir_kinect shows
set -eu
B=${B:-build}
out=$1
"$B/bin/dexel" sim hall -o "$out/hall.pcd" --size 160x120 --noise 0.003 --dropouts 0.02
"$B/bin/dexel" mesh "$out/hall.pcd" -o "$out/hall.ply"
(cd "$out" && sha256sum hall.ply >hall.sha256)
rm "$out/hall.ply"
"$B/hil/bin/redir_kinect" --pixels "$out/kinect.pixels"
