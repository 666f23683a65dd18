/*
 * The content hash of tiles: what their chunks say, whatever the encoding. Equal hashes are taken
 * for equal content; 0 is that of tiles without triangles. Not kept beyond the process.
 */
#ifndef DX_TILE_HASH_H
#define DX_TILE_HASH_H

#include "core/grid/rules.h"

/* Codes of cells and struts; ranges, attributes, normals and points of used dexels. */
uint64_t dx_tile_hash(const struct dx_tile *tile);

/* Of a tile that has nothing but codes and ranges, from what they were made of: another function of
 * the same content. A terrain takes one of the two for all its tiles. */
uint64_t dx_tile_hash_outcome(const struct dx_outcome *out, const struct dx_rules_scratch *made,
                              const struct dx_rows *rows);

#endif
