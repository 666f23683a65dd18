/*
 * A strip of columns of the grid under its geometry, for who wants points a row at a time: the
 * columns' part of the tables, the seam unwrapped. Columns outside the grid have zeros. One owner.
 */
#ifndef DX_STRIP_H
#define DX_STRIP_H

#include "core/grid/geometry.h"
#include "core/rows/rows.h"

struct dx_strip {
    const struct dx_geometry *geometry;
    const struct dx_rows *rows;
    int32_t col[DX_ROWS_N];    /* of the grid; -1 outside */
    uint8_t n_next[DX_ROWS_N]; /* columns from each one on that follow each other in the grid */
    struct dx_row_turn turn;   /* spinning */
    struct dx_row_points beam; /* pinhole: those of depth 1; table: the last row that was asked */
};

/* DX_ROWS_N columns from col0 on, which may be negative and beyond the end. */
void dx_strip_init(struct dx_strip *s, const struct dx_geometry *g, const struct dx_rows *rows,
                   int64_t col0);

/* Points of ranges r (metres) in a row of the grid: the bits of dx_geometry_point. */
void dx_strip_points(struct dx_row_points *out, struct dx_strip *s, uint32_t row, const float *r);

/* Directions of a row as the cap takes them: of length 1 (rows.h: unit), or for a pinhole, whose
 * ranges are depths, of depth 1. */
void dx_strip_beams(struct dx_row_points *out, struct dx_strip *s, uint32_t row);

#endif
