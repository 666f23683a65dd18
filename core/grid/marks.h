/*
 * Which tiles a change of some dexels reaches: bits by tile number. Whoever owns the bits says how
 * far it reaches; seam and borders are taken care of here.
 */
#ifndef DX_MARKS_H
#define DX_MARKS_H

#include "core/grid/tile.h"

/* Dexels row0..row1 of columns col0..col1, both ends included. */
struct dx_rect {
    uint32_t row0, row1, col0, col1;
};

/* The dexels that belong to a tile: 64 x 64, and one row and column more in the last ones of an
 * open grid. Each dexel belongs to one. */
struct dx_rect dx_marks_part(const struct dx_tiling *g, uint32_t tile);

/* Sets the bits of the tiles that own a cell from `before` rows and columns before the dexels to
 * `after` rows and columns after them (the cell of a dexel is the one whose corner a it is; in the
 * last row and column of an open grid the one before). */
void dx_marks_set(uint64_t *marks, const struct dx_tiling *g, const struct dx_rect *dexels,
                  uint32_t before, uint32_t after);

void dx_marks_set_all(uint64_t *marks, const struct dx_tiling *g);

static inline size_t dx_marks_n_words(const struct dx_tiling *g)
{
    return (size_t)dx_tiling_n_tiles(g) / 64 + 1;
}

static inline bool dx_marks_has(const uint64_t *marks, uint32_t n)
{
    return marks[n / 64] >> (n % 64) & 1;
}

#endif
