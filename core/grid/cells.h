/*
 * The cell rule: from a cell's six edges to its triangles. t1 = abc, t2 = acd, t3 = abd, t4 = bcd;
 * b-d is taken where it gives more triangles, or as many and the diagonal rule prefers it. A
 * missing corner makes its edges 0, so cells of three corners are included.
 */
#ifndef DX_CELLS_H
#define DX_CELLS_H

#include "core/grid/diagonal.h"

/* Scratch, and what comes out: the three bits of the codes (enum dx_cell) of the tile in the middle
 * of the area, by rows. */
struct dx_cells {
    struct dx_diagonal diagonal;
    uint64_t bit[3][DX_TILE_CELLS];
};

void dx_cells_decide(struct dx_cells *cells, const struct dx_area *a, const struct dx_gates *gates,
                     const struct dx_geometry *g, const struct dx_tiling *tiling);

/* The codes, row stride DX_TILE_CELLS. */
void dx_cells_code(uint8_t code[DX_TILE_CELLS * DX_TILE_CELLS], const struct dx_cells *cells,
                   const struct dx_rows *rows);

#endif
