/* The loops for x86-64 with AVX2: the Makefile compiles this file for it, and no other. */
#include "core/rows/rows_priv.h"

#include "core/rows/rows_movemask.h"
#include "core/rows/rows_shuffle.h"

#include "core/rows/rows_eights.h"
#include "core/rows/rows_table.h"

const struct dx_rows dx_rows_avx2 = DX_ROWS_TABLE("avx2");
