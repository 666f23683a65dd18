/* The tables that rows.c chooses from. */
#ifndef DX_ROWS_PRIV_H
#define DX_ROWS_PRIV_H

#include "core/rows/rows.h"

extern const struct dx_rows dx_rows_generic;
extern const struct dx_rows dx_rows_avx2, dx_rows_avx512; /* x86-64 only */

#endif
