/*
 * Which faces a geometry's directions allow: cells that fold, and struts whose triangles would look
 * away from the scanner (near the poles, and where a table of directions is crooked).
 */
#ifndef DX_FACES_H
#define DX_FACES_H

#include "core/grid/geometry.h"

/* Bit per cell i * cell_cols + j that folds; NULL when none can. Errors: -ENOMEM. */
int dx_faces_find_folds(uint64_t **folded, const struct dx_geometry *g);

/* Whether all triangles face the scanner that struts of this direction and length can make whose
 * first missing dexel is (i, j). */
bool dx_faces_span(const struct dx_geometry *g, bool across, uint8_t len, uint32_t i, uint32_t j);

/* Whether the triangle of three dexels (row, column), which runs as a cell's abc does, faces the
 * scanner. Never one that spans too much of the sky for its sign to mean anything. */
bool dx_faces_triangle(const struct dx_geometry *g, const uint32_t at[3][2]);

/* Whether a fan over the dexels of the row faces the scanner; `below` when its triangles continue
 * cells below it (the first row), else above (the last one). */
bool dx_faces_fan(const struct dx_geometry *g, uint32_t row, bool below);

#endif
