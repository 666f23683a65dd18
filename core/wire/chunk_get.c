/*
 * Chunk decoders: every length, count, bit and index of a chunk is checked before it is used, so
 * that a subscriber survives whatever a server sends. Pure functions.
 */
#include "core/wire/chunk.h"

#include <errno.h>

/* Cells of a tile in one direction, of `cells` in the whole grid. */
static uint32_t cells_of(uint32_t cells, uint32_t tile)
{
    const uint32_t left = cells - tile * DX_TILE_CELLS;

    return left < DX_TILE_CELLS ? left : DX_TILE_CELLS;
}

static int attr_bytes_of(uint8_t sections)
{
    switch (sections) {
    case 0:
        return 0;
    case DX_CHUNK_ATTR8:
        return 1;
    case DX_CHUNK_ATTR16:
        return 2;
    default:
        return -EBADMSG;
    }
}

int dx_chunk_get_header(struct dx_chunk_header *h, const uint8_t *body, size_t len,
                        const struct dx_tiling *tiling)
{
    struct dx_reader r = dx_reader_init(body, len);
    uint32_t cell_rows, cell_cols;
    int attr_bytes;

    h->row = dx_read_u16(&r);
    h->col = dx_read_u16(&r);
    h->encoding = dx_read_u8(&r);
    attr_bytes = attr_bytes_of(dx_read_u8(&r));
    h->n_vertices = dx_read_u16(&r);
    h->n_triangles = dx_read_u16(&r);
    if (r.failed || attr_bytes < 0 || h->row >= tiling->rows || h->col >= tiling->cols ||
        h->encoding >= DX_N_ENCODINGS)
        return -EBADMSG;
    h->attr_bytes = (uint8_t)attr_bytes;
    if (h->n_triangles == 0)
        return h->n_vertices == 0 && attr_bytes == 0 && len == DX_CHUNK_HEADER_LEN ? 0 : -EBADMSG;
    cell_rows = cells_of(tiling->cell_rows, h->row);
    cell_cols = cells_of(tiling->cell_cols, h->col);
    if (h->n_triangles > 2 * cell_rows * cell_cols || h->n_vertices < 3 ||
        h->n_vertices > (cell_rows + 1) * (cell_cols + 1))
        return -EBADMSG;
    return 0;
}

/* Counts the mask's dexels; -EBADMSG when one is not a corner of the tile's cells. */
static int count_mask(const uint8_t mask[DX_MASK_BYTES], uint32_t cell_rows, uint32_t cell_cols)
{
    int n = 0;

    for (uint32_t byte = 0; byte < DX_MASK_BYTES; byte++) {
        for (uint32_t bits = mask[byte]; bits; bits &= bits - 1) {
            const uint32_t k = 8 * byte + (uint32_t)__builtin_ctz(bits);
            const uint32_t row = k / DX_BLOCK, col = k % DX_BLOCK;

            if (row < 1 || row > cell_rows + 1 || col < 1 || col > cell_cols + 1)
                return -EBADMSG;
            n++;
        }
    }
    return n;
}

static void get_attrs(uint16_t *attr, const uint8_t *p, uint32_t n, uint8_t attr_bytes)
{
    if (attr_bytes == 2)
        dx_get_u16s(attr, p, n);
    for (uint32_t i = 0; attr_bytes == 1 && i < n; i++)
        attr[i] = p[i];
}

static int get_f32(struct dx_tile_mesh *mesh, const struct dx_chunk_header *h, const uint8_t *p,
                   size_t len, const struct dx_tiling *tiling)
{
    const uint32_t n = h->n_vertices, n_index = 3u * h->n_triangles;
    uint32_t highest = 0;

    if (len != DX_MASK_BYTES + 12u * n + 2u * n_index + (size_t)h->attr_bytes * n)
        return -EBADMSG;
    memcpy(mesh->mask, p, DX_MASK_BYTES);
    if (count_mask(mesh->mask, cells_of(tiling->cell_rows, h->row),
                   cells_of(tiling->cell_cols, h->col)) != (int)n)
        return -EBADMSG;
    p += DX_MASK_BYTES;
    dx_get_f32s(mesh->xyz, p, 3 * (size_t)n);
    p += 12 * (size_t)n;
    dx_get_u16s(mesh->index, p, n_index);
    p += 2 * (size_t)n_index;
    for (uint32_t i = 0; i < n_index; i++)
        highest = mesh->index[i] > highest ? mesh->index[i] : highest;
    if (highest >= n)
        return -EBADMSG;
    get_attrs(mesh->attr, p, n, h->attr_bytes);
    return 0;
}

/* Codes into `tile`; the triangles they make, or -EBADMSG. */
static int get_codes(struct dx_tile *tile, const uint8_t *p)
{
    static const uint8_t triangles[8] = {0, 1, 1, 2, 1, 1, 2, 0};
    uint32_t bits = 0, n_bits = 0;
    int n = 0;

    for (uint32_t i = 0; i < tile->cell_rows; i++) {
        for (uint32_t j = 0; j < tile->cell_cols; j++) {
            if (n_bits < 3) {
                bits |= (uint32_t)*p++ << n_bits;
                n_bits += 8;
            }
            if ((bits & 7) == 7)
                return -EBADMSG;
            tile->code[DX_TILE_CELLS * i + j] = bits & 7;
            n += triangles[bits & 7];
            bits >>= 3;
            n_bits -= 3;
        }
    }
    return bits ? -EBADMSG : n;
}

/* Ranges and attributes from rank order to where `mask` puts them. */
static int get_samples(struct dx_tile *tile, const uint8_t mask[DX_MASK_BYTES],
                       const uint8_t *range, const uint8_t *attr)
{
    for (uint32_t byte = 0; byte < DX_MASK_BYTES; byte++) {
        for (uint32_t bits = mask[byte]; bits; bits &= bits - 1) {
            const uint32_t k = 8 * byte + (uint32_t)__builtin_ctz(bits);

            tile->range[k] = dx_get_u16(range);
            if (tile->range[k] == 0)
                return -EBADMSG;
            range += 2;
            if (tile->attr_bytes)
                tile->attr[k] = tile->attr_bytes == 2 ? dx_get_u16(attr) : *attr;
            attr += tile->attr_bytes;
        }
    }
    return 0;
}

static int get_q16(struct dx_tile_mesh *mesh, const struct dx_chunk_header *h, const uint8_t *p,
                   size_t len, const struct dx_tiling *tiling, const struct dx_geometry *g)
{
    struct dx_tile tile = {.row = h->row,
                           .col = h->col,
                           .attr_bytes = h->attr_bytes,
                           .cell_rows = (uint8_t)cells_of(tiling->cell_rows, h->row),
                           .cell_cols = (uint8_t)cells_of(tiling->cell_cols, h->col)};
    const size_t codes_len = (3u * tile.cell_rows * tile.cell_cols + 7) / 8;
    const size_t n = h->n_vertices;
    int r;

    if (!g || len != codes_len + 2 * n + h->attr_bytes * n)
        return -EBADMSG;
    if (get_codes(&tile, p) != h->n_triangles || dx_tile_mask(&tile, mesh->mask) != n)
        return -EBADMSG;
    p += codes_len;
    r = get_samples(&tile, mesh->mask, p, p + 2 * n);
    if (r < 0)
        return r;
    dx_tile_mesh_build(mesh, &tile, tiling, g);
    return 0;
}

int dx_chunk_get(struct dx_tile_mesh *mesh, const uint8_t *body, size_t len,
                 const struct dx_tiling *tiling, const struct dx_geometry *g)
{
    struct dx_chunk_header h;
    int r = dx_chunk_get_header(&h, body, len, tiling);

    if (r < 0)
        return r;
    mesh->row = h.row;
    mesh->col = h.col;
    mesh->attr_bytes = h.attr_bytes;
    mesh->n_vertices = h.n_vertices;
    mesh->n_triangles = h.n_triangles;
    if (h.n_triangles == 0) {
        memset(mesh->mask, 0, DX_MASK_BYTES);
        return 0;
    }
    body += DX_CHUNK_HEADER_LEN;
    len -= DX_CHUNK_HEADER_LEN;
    return h.encoding == DX_ENCODING_F32 ? get_f32(mesh, &h, body, len, tiling)
                                         : get_q16(mesh, &h, body, len, tiling, g);
}
