# For the scripts of this folder to source, with $B and skip() set: installs PCL when it is not there, and
# build_pcl NAME makes tests/peers/NAME.cpp into $B/peers/NAME.
. tests/peers/build_peer.sh
for header in /usr/include/pcl-1.*/pcl/surface/organized_fast_mesh.h; do
  install_for_peers "$header" libpcl-dev || skip "libpcl-dev is not there and could not be installed"
done
command -v g++ >/dev/null || skip "no g++"

build_pcl() {
  build_peer "$1" "$(pkg-config --cflags-only-I pcl_io pcl_surface eigen3 | sed 's/-I/-isystem /g')" \
    "-lpcl_io -lpcl_surface -lpcl_search -lpcl_kdtree -lpcl_common"
}
