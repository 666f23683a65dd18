# For bench_peers.sh to source after pcl.sh: builds the program for VTK, which libpcl-dev brings with it. $vtk is
# then its path, or empty.
vtk=

build_vtk() { # DIRECTORY of VTK's headers
  version=${1##*/vtk-}
  libraries=
  for name in CommonCore CommonDataModel CommonExecutionModel FiltersGeometry FiltersCore; do
    libraries="$libraries -lvtk$name-$version"
  done
  build_peer vtk_grid "$(pkg-config --cflags-only-I pcl_io eigen3 | sed 's/-I/-isystem /g') -isystem $1" \
    "-lpcl_io -lpcl_common $libraries" && vtk=$B/peers/vtk_grid
}

for headers in /usr/include/vtk-9*; do
  if [ -e "$headers/vtkStructuredGrid.h" ]; then build_vtk "$headers"; else echo "peers: no VTK beside PCL" >&2; fi
done
