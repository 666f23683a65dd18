/*
 * Chunks: the body of a TILE message, in one of the encodings. An encoder writes into the caller's
 * memory, a decoder checks every length and every index before use. Pure functions on bytes; any
 * thread. docs/protocol.md specifies the bytes; in short:
 *
 *   u16 tile_row | u16 tile_col | u8 encoding | u8 sections | u16 n_vertices | u16 n_triangles
 *   attribute section, when its bit is set: n_vertices of u8 or u16
 *   f32    mask (DX_MASK_BYTES), n_vertices * 3 f32, n_triangles * 3 u16
 *   q16    cell codes, three bits each, row by row over the tile's own cells, LSB first; struts;
 *          n_vertices u16 ranges in rank order. The mask follows from the codes.
 *   delta  cell codes in groups of eight; struts; ranges as residuals of a predictor
 * (delta.h) normal section, when its bit is set: n_vertices * 2 i8
 *
 * One section stands before the encoding's part and one behind it, so that leaving out either or
 * both leaves bytes that lie together: the server never copies a chunk to cut it. An empty tile (no
 * triangles) is the header alone, with zero counts and sections.
 */
#ifndef DX_CHUNK_H
#define DX_CHUNK_H

#include "core/grid/tile.h"
#include "core/wire/wire.h"

#define DX_CHUNK_HEADER_LEN   10
#define DX_CHUNK_SECTIONS_AT  5     /* where the header keeps them */
#define DX_CHUNK_TRIANGLES_AT 8     /* and how many there are */
#define DX_CHUNK_ATTR8        0x01u /* section bits */
#define DX_CHUNK_ATTR16       0x02u
#define DX_CHUNK_NORMALS      0x04u
#define DX_CHUNK_SMOOTHED     0x08u /* of no section: the vertices are no samples */

/* The longest chunk of an encoding (with a 16-bit attribute and normals). */
size_t dx_chunk_max_len(enum dx_encoding encoding);

/* Encodes a tile into `out` (of dx_chunk_max_len) and returns the length. f32 makes its points
 * under the geometry; q16 needs 16-bit ranges. A mesh that is not the whole tile's goes as f32. */
size_t dx_chunk_put_f32(uint8_t *out, const struct dx_tile *tile, const struct dx_tiling *tiling,
                        const struct dx_geometry *g);
size_t dx_chunk_put_q16(uint8_t *out, const struct dx_tile *tile);
size_t dx_chunk_put_delta(uint8_t *out, const struct dx_tile *tile);
size_t dx_chunk_put_mesh(uint8_t *out, const struct dx_tile_mesh *mesh);
size_t dx_chunk_put_empty(uint8_t *out, enum dx_encoding encoding, uint32_t tile_row,
                          uint32_t tile_col);

/* Says of a chunk that its ranges are smoothed; of an empty one there is nothing to say. */
void dx_chunk_set_smoothed(uint8_t *chunk);

/* A chunk without the sections that are not wanted: `head` in place of its header, then `len` bytes
 * from `skip` on. */
struct dx_chunk_cut {
    uint8_t head[DX_CHUNK_HEADER_LEN];
    uint32_t skip, len;
};

/* `header` is the first DX_CHUNK_HEADER_LEN bytes of a chunk of `len` bytes that an encoder made;
 * `keep` section bits. */
void dx_chunk_cut(struct dx_chunk_cut *cut, const uint8_t *header, uint32_t len, uint8_t keep);

struct dx_chunk_header {
    uint16_t row, col; /* of the tile */
    uint8_t encoding, attr_bytes;
    bool has_normals;
    bool smoothed;                    /* the vertices are no samples */
    uint16_t n_vertices, n_triangles; /* both 0: an empty tile */
};

/* What the first bytes of a chunk say. 0, or -EBADMSG: too short, tile outside the grid, unknown
 * encoding or sections, counts that no tile can have. */
int dx_chunk_get_header(struct dx_chunk_header *h, const uint8_t *body, size_t len,
                        const struct dx_tiling *tiling);

/*
 * Decodes any chunk into a mesh. `g` gives q16 and delta their points (NULL for f32) and `tiling`
 * bounds the tile. 0, or -EBADMSG: what dx_chunk_get_header refuses, bad length, a count that does
 * not match the mask or the codes, an index out of range, a cell code above 6, a strut code that
 * dx_strut_decode refuses, a strut's owner or corner or a bit of the mask outside the block or the
 * grid, a range of 0 at a used dexel, a normal's coordinate of -128.
 */
int dx_chunk_get(struct dx_tile_mesh *mesh, const uint8_t *body, size_t len,
                 const struct dx_tiling *tiling, const struct dx_geometry *g);

#endif
