/*
 * Chunks: the body of a TILE message, in one of the encodings. An encoder writes into the caller's
 * memory, a decoder checks every length and every index before use. Pure functions on bytes; any
 * thread.
 *
 * Body: u16 tile_row | u16 tile_col | u8 encoding | u8 sections | u16 n_vertices | u16 n_triangles,
 * then f32: mask (DX_MASK_BYTES), n_vertices * 3 f32, n_triangles * 3 u16 q16: cell codes, three
 * bits each, row by row over the tile's own cells, LSB first; n_vertices u16 ranges in rank order.
 * The mask follows from the codes. Then the attribute section (when its bit is set): n_vertices of
 * u8 or u16. An empty tile (no triangles) is the header alone, with zero counts and sections.
 */
#ifndef DX_CHUNK_H
#define DX_CHUNK_H

#include "core/grid/tile.h"
#include "core/wire/wire.h"

#define DX_CHUNK_HEADER_LEN 10
#define DX_CHUNK_ATTR8      0x01u /* section bits */
#define DX_CHUNK_ATTR16     0x02u

/* The longest chunk of an encoding (with a 16-bit attribute). */
size_t dx_chunk_max_len(enum dx_encoding encoding);

/* Encodes a tile into `out` (of dx_chunk_max_len) and returns the length. f32 takes `mesh` (built
 * from `tile` by the caller, so that it can be shared); q16 takes the tile alone and needs 16-bit
 * ranges. */
size_t dx_chunk_put_f32(uint8_t *out, const struct dx_tile_mesh *mesh);
size_t dx_chunk_put_q16(uint8_t *out, const struct dx_tile *tile);
size_t dx_chunk_put_empty(uint8_t *out, enum dx_encoding encoding, uint32_t tile_row,
                          uint32_t tile_col);

struct dx_chunk_header {
    uint16_t row, col; /* of the tile */
    uint8_t encoding, attr_bytes;
    uint16_t n_vertices, n_triangles; /* both 0: an empty tile */
};

/* What the first bytes of a chunk say. 0, or -EBADMSG: too short, tile outside the grid, unknown
 * encoding or sections, counts that no tile can have. */
int dx_chunk_get_header(struct dx_chunk_header *h, const uint8_t *body, size_t len,
                        const struct dx_tiling *tiling);

/*
 * Decodes any chunk into a mesh. `g` gives q16 its points (NULL for f32) and `tiling` bounds the
 * tile. 0, or -EBADMSG: what dx_chunk_get_header refuses, bad length, a count that does not match
 * the mask or the codes, an index out of range, a code above 6, a range of 0 at a used dexel, a bit
 * outside the tile (the mask may name the corners of the tile's own cells only).
 */
int dx_chunk_get(struct dx_tile_mesh *mesh, const uint8_t *body, size_t len,
                 const struct dx_tiling *tiling, const struct dx_geometry *g);

#endif
