/*
 * The cell rule: from a cell's six edges to its triangles. t1 = abc, t2 = acd, t3 = abd, t4 = bcd;
 * b-d is taken where it gives more triangles, or as many and the diagonal rule prefers it. A
 * missing corner makes its edges 0, so cells of three corners are included.
 */
#ifndef DX_CELLS_H
#define DX_CELLS_H

#include "core/grid/diagonal.h"

/* Cell codes (enum dx_cell, row stride DX_TILE_CELLS) of the tile in the middle of the area. */
void dx_cells_code(uint8_t code[DX_TILE_CELLS * DX_TILE_CELLS], struct dx_diagonal *diagonal,
                   const struct dx_area *a, const struct dx_gates *gates,
                   const struct dx_geometry *g, const struct dx_tiling *tiling);

#endif
