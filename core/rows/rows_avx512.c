/* The loops for x86-64 with AVX-512 (as x86-64-v4 has it, and VBMI2): the Makefile compiles this
 * file for it.
 */
#include "core/rows/rows_priv.h"

#include "core/rows/rows_masks.h"
#include "core/rows/rows_compress.h"
#include "core/rows/rows_table.h"

const struct dx_rows dx_rows_avx512 = DX_ROWS_TABLE("avx512");
