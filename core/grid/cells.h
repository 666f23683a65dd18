/*
 * The scalar reference of terrain mode: the edge rule and the cell rule on one tile, in integers.
 * It is the oracle for every faster kernel and stays readable. Reads the published array and the
 * constants; writes only its scratch; any number of tiles at once.
 */
#ifndef DX_CELLS_H
#define DX_CELLS_H

#include "core/grid/gates.h"

#define DX_CELL_BLOCK  (DX_TILE_CELLS + 1) /* dexels a side that a tile's cells touch */
#define DX_CELL_STRIDE (DX_CELL_BLOCK + 1) /* of a row: each has a right neighbour */

/* A tile's dexels with what a kernel needs at hand; columns past the seam already unwrapped. One
 * per thread, zeroed when it is made: a smaller tile leaves what was there beside its own. */
struct dx_cell_block {
    uint32_t row0;           /* of the grid */
    uint32_t n_rows, n_cols; /* cells */
    uint16_t range16[DX_CELL_BLOCK][DX_CELL_STRIDE];
    uint32_t range32[DX_CELL_BLOCK][DX_CELL_STRIDE]; /* wide only */
    uint16_t noise[DX_CELL_BLOCK]
                  [DX_CELL_BLOCK]; /* narrow only: t0 + quadratic term of each range */
    uint32_t c[DX_N_EDGES][DX_CELL_BLOCK][DX_CELL_STRIDE];   /* uneven grids only */
    uint16_t c16[DX_N_EDGES][DX_CELL_BLOCK][DX_CELL_STRIDE]; /* the same, narrow only */
    int32_t direction[DX_CELL_BLOCK][DX_CELL_STRIDE][3];     /* capped only; unit vectors * 2^24 */
};

/* Cell codes (enum dx_cell, row stride DX_TILE_CELLS) of tile (row, col) of the published plane. */
void dx_cells_compute(uint8_t code[DX_TILE_CELLS * DX_TILE_CELLS], struct dx_cell_block *scratch,
                      const struct dx_plane *plane, const struct dx_tiling *tiling,
                      const struct dx_geometry *g, const struct dx_gates *gates, enum dx_diag diag,
                      uint32_t tile_row, uint32_t tile_col);

#endif
