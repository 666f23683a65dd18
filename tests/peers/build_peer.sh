# For the scripts of this folder to source, with $B and skip() set.

install_for_peers() { # HEADER PACKAGE...: installs the packages when there is no such header; 1: that cannot be done
  [ ! -e "$1" ] || return 0
  shift
  sudo=
  [ "$(id -u)" = 0 ] || sudo=sudo
  echo "peers: installing $*" >&2
  { DEBIAN_FRONTEND=noninteractive $sudo apt-get install -y --no-install-recommends g++ "$@" ||
    { $sudo apt-get update && DEBIAN_FRONTEND=noninteractive $sudo apt-get install -y --no-install-recommends \
      g++ "$@"; }; } >/dev/null 2>&1
}

build_peer() { # NAME INCLUDES LIBRARIES: tests/peers/NAME.cpp into $B/peers/NAME
  mkdir -p "$B/peers"
  [ "$B/peers/$1" -nt "tests/peers/$1.cpp" ] && [ -z "$(find tests/peers -name '*.hpp' -newer "$B/peers/$1")" ] && return
  # shellcheck disable=SC2086 # lists of words
  g++ -O3 -std=c++17 -Wall -Wextra $2 "tests/peers/$1.cpp" -o "$B/peers/$1" $3
}
