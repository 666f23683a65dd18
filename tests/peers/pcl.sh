# For the scripts of this folder to source, with $B and skip() set: installs PCL when it is not there, and
# build_pcl NAME makes tests/peers/NAME.cpp into $B/peers/NAME.
if [ ! -e /usr/include/pcl-1.*/pcl/surface/organized_fast_mesh.h ]; then
  sudo=
  [ "$(id -u)" = 0 ] || sudo=sudo
  echo "peers: installing libpcl-dev" >&2
  { DEBIAN_FRONTEND=noninteractive $sudo apt-get install -y --no-install-recommends g++ libpcl-dev ||
    { $sudo apt-get update && DEBIAN_FRONTEND=noninteractive $sudo apt-get install -y --no-install-recommends \
      g++ libpcl-dev; }; } >/dev/null 2>&1 || skip "libpcl-dev is not there and could not be installed"
fi
command -v g++ >/dev/null || skip "no g++"

build_peer() { # NAME INCLUDES LIBRARIES
  mkdir -p "$B/peers"
  [ "$B/peers/$1" -nt "tests/peers/$1.cpp" ] && [ "$B/peers/$1" -nt tests/peers/peer.hpp ] && return
  # shellcheck disable=SC2086 # lists of words
  g++ -O3 -std=c++17 -Wall -Wextra $2 "tests/peers/$1.cpp" -o "$B/peers/$1" $3
}

build_pcl() {
  build_peer "$1" "$(pkg-config --cflags-only-I pcl_io pcl_surface eigen3 | sed 's/-I/-isystem /g')" \
    "-lpcl_io -lpcl_surface -lpcl_search -lpcl_kdtree -lpcl_common"
}
