/*
 * Lines of three dexels: with which weights a plane's inverse range at the middle one follows from
 * its neighbours. n.(r d) = h makes 1/r = (n/h).d linear in the direction d, so the weights are
 * those that give d(x) from d(x-) and d(x+): exact on a great circle, and to second order on a row
 * of a latitude-longitude grid. For a pinhole, depth takes the place of range and (X, Y, 1) of d.
 */
#ifndef DX_LINES_H
#define DX_LINES_H

#include "core/grid/gates.h"

/* What inverse range is linear in: the direction, or (X, Y, 1) of a pinhole. */
void dx_lines_direction(const struct dx_geometry *g, uint32_t row, uint32_t col, double d[3]);

/* Weights of the lines of direction e: [i] those of column 1, or per_dexel [i * width + j]. */
void dx_lines_fill(struct dx_line *line, const struct dx_geometry *g, enum dx_edge e,
                   bool per_dexel);

/* The weights at dexel (i,j) of the line whose neighbours are di rows and dj columns before and
 * after it; 0, 0 where one of them is outside the grid. */
struct dx_line dx_lines_at(const struct dx_geometry *g, uint32_t i, uint32_t j, int di, int dj);

#endif
