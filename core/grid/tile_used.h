/*
 * Which dexels of a tile's block are vertices of its mesh, one byte each, and their ranks: what the
 * parts of the tile and the chunk encodings share.
 */
#ifndef DX_TILE_USED_H
#define DX_TILE_USED_H

#include "core/grid/tile.h"

#define DX_USED_ROOM ((DX_BLOCK_DEXELS + 7) / 8 * 8) /* whole eights */

/* 1 where a cell or a strut uses the block dexel. */
struct dx_used {
    uint8_t at[DX_USED_ROOM]; /* zeros at the end */
};

void dx_used_mark(struct dx_used *used, const struct dx_tile *tile);
void dx_used_pack(const struct dx_used *used, uint8_t mask[DX_MASK_BYTES]);

/* rank[k] = used dexels before k; returns their number. */
uint32_t dx_used_rank(const struct dx_used *used, uint16_t rank[DX_USED_ROOM]);

/* Triangles of the cells row by row, then of the struts in block order of their owners, as ranks;
 * returns how many. Oriented to face the scanner (`flip` is the geometry's). `index` has the room
 * of struct dx_tile_mesh. */
uint32_t dx_tile_emit(const struct dx_tile *tile, const uint16_t rank[DX_BLOCK_DEXELS], bool flip,
                      uint16_t *index);

#endif
