/* A service for grids that tests have: its streams reserve 2 GiB of address space, not 64. valgrind
 * has no more to give. */
#include "daemon/stream.h"

const uint32_t dx_stream_max_tiles = 512;
