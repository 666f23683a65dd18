/*
 * Parts of chunks that several encodings share, or that have a file of their own. Included by
 * chunk_*.c alone. A `get` returns where the bytes go on, or NULL when they are bad.
 */
#ifndef DX_CHUNK_PARTS_H
#define DX_CHUNK_PARTS_H

#include "core/grid/tile_used.h"
#include "core/wire/chunk.h"

/* The most struts that a tile with V vertices has is DX_BLOCK_DEXELS - V: a strut is owned by a
 * missing dexel, which is no vertex. So a strut and a vertex together take at most what two bytes
 * a block dexel are, and 255s. */
#define DX_CHUNK_STRUTS_MAX (2 + DX_BLOCK_DEXELS / 255 + 1)

/* ---- rectangle of a tile in the grid -------------------------------------------------------- */

/* Whether block dexel (p, q) of a tile is in the grid. */
static inline bool dx_chunk_in_grid(const struct dx_tiling *t, uint32_t row, uint32_t col, int p,
                                    int q)
{
    int64_t i = (int64_t)row * DX_TILE_CELLS + p - 1, j = (int64_t)col * DX_TILE_CELLS + q - 1;

    return p >= 0 && p < DX_BLOCK && q >= 0 && q < DX_BLOCK && i >= 0 && i < t->height &&
           (t->wrap || (j >= 0 && j < t->width));
}

/* ---- struts: chunk_struts.c ----------------------------------------------------------------- */

uint8_t *dx_chunk_put_struts(uint8_t *p, const struct dx_tile *tile, const struct dx_used *used);

/* Into `tile`, whose struts are all 0 before; adds their triangles to *n_triangles. */
const uint8_t *dx_chunk_get_struts(struct dx_tile *tile, const uint8_t *p, const uint8_t *end,
                                   const struct dx_tiling *tiling, uint32_t *n_triangles);

/* ---- delta: chunk_delta_put.c, chunk_delta_get.c -------------------------------------------- */

uint8_t *dx_delta_put_codes(uint8_t *p, const struct dx_tile *tile);
uint8_t *dx_delta_put_ranges(uint8_t *p, const struct dx_tile *tile, const struct dx_used *used);

/* Codes into `tile`, whose codes are all 0 before. Ranges of the used dexels. */
const uint8_t *dx_delta_get_codes(struct dx_tile *tile, const uint8_t *p, const uint8_t *end);
const uint8_t *dx_delta_get_ranges(struct dx_tile *tile, const struct dx_used *used,
                                   const uint8_t *p, const uint8_t *end);

#endif
