/* How large a stream's grid may become. A file of its own: tests link a smaller one. */
#include "daemon/stream.h"

const uint32_t dx_stream_max_tiles = 16384;
