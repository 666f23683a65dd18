/*
 * Which diagonal of a cell is preferred where both would do (docs/terrain.md): the fixed one a-c,
 * the shorter one in range, or the one along which the surface bends less (a diagonal along a
 * crease does not bend, one across it does), and a-c unless b-d is better by a margin of noise, so
 * that flat noisy ground does not flicker.
 */
#ifndef DX_DIAGONAL_H
#define DX_DIAGONAL_H

#include "core/grid/area.h"

/* Scratch that carries from a row of cells to the next: inverse ranges by area row & 7, weights by
 * area row & 1. Inverse ranges are made a row before they are read: a load across two stores waits
 * until they are done. */
struct dx_diagonal {
    union { /* near 2^40 / range */
        float narrow[8][DX_ROWS_CORNERS];
        double wide[8][DX_ROWS_CORNERS];
    } inverse;
    struct dx_row_weights weights[2][DX_ROWS_CORNERS + 1]; /* on even grids the first alone */
};

/* Before the first row. */
void dx_diagonal_begin(struct dx_diagonal *d, const struct dx_area *a, const struct dx_gates *gates,
                       const struct dx_geometry *g);

/* The cells of area row p; rows follow each other. Where it is unsure, dx_diagonal_decide tells. */
struct dx_row_preference dx_diagonal_row(struct dx_diagonal *d, const struct dx_area *a,
                                         const struct dx_gates *gates, const struct dx_geometry *g,
                                         uint32_t p);

/* In integers: whether cell (p, q), all of whose corners are there, prefers b-d. */
bool dx_diagonal_decide(const struct dx_area *a, const struct dx_gates *gates,
                        const struct dx_geometry *g, uint32_t p, uint32_t q);

#endif
