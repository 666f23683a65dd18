/*
 * Which diagonal cuts a cell that both would cut as well. `short`: the one whose ends differ less
 * in range. `bend`: the one along which the surface bends less in inverse range (a diagonal along a
 * crease does not bend, one across it does), and a-c unless b-d is better by a margin of noise, so
 * that flat noisy surfaces do not flicker.
 */
#ifndef DX_DIAGONAL_H
#define DX_DIAGONAL_H

#include "core/grid/area.h"

/* prefer_bd[q] of the cells of area row p, for the tile's columns (q from DX_MARGIN on). `lines` is
 * scratch that carries residuals from a row to the next; dx_diagonal_begin before the first row. */
struct dx_diagonal {
    struct dx_residuals {
        int64_t ac[DX_AREA_STRIDE], bd[DX_AREA_STRIDE];
        uint8_t has_ac[DX_AREA_STRIDE], has_bd[DX_AREA_STRIDE];
    } line[2]; /* of even and odd area rows */
};

void dx_diagonal_begin(struct dx_diagonal *d, const struct dx_area *a, const struct dx_gates *gates,
                       const struct dx_geometry *g);
void dx_diagonal_row(uint8_t prefer_bd[DX_AREA_STRIDE], struct dx_diagonal *d,
                     const struct dx_area *a, const struct dx_gates *gates,
                     const struct dx_geometry *g, uint32_t p);

#endif
