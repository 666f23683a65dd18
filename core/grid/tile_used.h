/*
 * Which dexels of a tile's block are vertices of its mesh, and their ranks: what the parts of the
 * tile and the chunk encodings share.
 */
#ifndef DX_TILE_USED_H
#define DX_TILE_USED_H

#include "core/grid/tile.h"
#include "core/rows/row_bits.h"

struct dx_used {
    dx_bits row[DX_BLOCK];        /* block rows; bit j: a cell or a strut uses column j */
    dx_bits strut[DX_BLOCK];      /* bit j: the dexel of column j owns a strut */
    uint16_t first[DX_BLOCK + 1]; /* ranks of their first used dexels; and how many there are */
    bool has_struts;
};

/* The three bits of a tile's codes. */
void dx_used_bits(uint64_t bit[3][DX_TILE_CELLS], const uint8_t *code);

/* Of the codes of a tile's cells, by their three bits, and of its struts (NULL: none), laid out as
 * in struct dx_tile; and the same of the codes as they are there. */
void dx_used_of(struct dx_used *used, const uint64_t bit[3][DX_TILE_CELLS], const uint8_t *strut);
void dx_used_mark(struct dx_used *used, const uint8_t *code, const uint8_t *strut);

/* One block dexel more; and the ranks anew after the last one. */
void dx_used_add(struct dx_used *used, uint32_t k);
void dx_used_number(struct dx_used *used);

void dx_used_pack(const struct dx_used *used, uint8_t mask[DX_MASK_BYTES]);

static inline uint32_t dx_used_count(const struct dx_used *used)
{
    return used->first[DX_BLOCK];
}

static inline bool dx_used_has(const struct dx_used *used, uint32_t k)
{
    return dx_bits_at(used->row[k / DX_BLOCK], k % DX_BLOCK);
}

#define DX_RANK_ROOM (DX_BLOCK_DEXELS + 16) /* whole vectors */

/* By block dexel, where it is used: used ones before it. */
void dx_used_rank(const struct dx_used *used, uint16_t rank[DX_RANK_ROOM]);

/* Triangles of the cells row by row, then of the struts in block order of their owners, as ranks;
 * returns how many. Oriented to face the scanner (`flip` is the geometry's). `index` has the room
 * of struct dx_tile_mesh. */
uint32_t dx_tile_emit(const struct dx_tile *tile, const struct dx_used *used, bool flip,
                      dx_packed_u16 *index);

/* Points of the used dexels in rank order, as they came or under the geometry, metres, scanner
 * frame. `xyz` has the room of struct dx_tile_mesh. */
void dx_tile_points(const struct dx_tile *tile, const struct dx_used *used,
                    const struct dx_tiling *tiling, const struct dx_geometry *g,
                    dx_packed_f32 *xyz);

#endif
