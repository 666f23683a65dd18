/* The loops for every processor of the kind that is built for. */
#include "core/rows/rows_loops.h"
#include "core/rows/rows_priv.h"

const struct dx_rows dx_rows_generic = DX_ROWS_TABLE("generic");
