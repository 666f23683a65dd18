/*
 * Chunk decoders: every length, count, bit and index of a chunk is checked before it is used, so
 * that a subscriber survives whatever a server sends. Pure functions.
 */
#include "core/grid/octahedral.h"
#include "core/rows/rows.h"
#include "core/wire/bits.h"
#include "core/wire/chunk_parts.h"

#include <errno.h>

/* ---- header --------------------------------------------------------------------------------- */

/* Cells of a tile in one direction, of `cells` in the whole grid. */
static uint32_t cells_of(uint32_t cells, uint32_t tile)
{
    const uint32_t left = cells - tile * DX_TILE_CELLS;

    return left < DX_TILE_CELLS ? left : DX_TILE_CELLS;
}

static int attr_bytes_of(uint8_t sections)
{
    switch (sections & ~(DX_CHUNK_NORMALS | DX_CHUNK_SMOOTHED)) {
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
    uint8_t sections;
    int attr_bytes;

    h->row = dx_read_u16(&r);
    h->col = dx_read_u16(&r);
    h->encoding = dx_read_u8(&r);
    sections = dx_read_u8(&r);
    h->n_vertices = dx_read_u16(&r);
    h->n_triangles = dx_read_u16(&r);
    attr_bytes = attr_bytes_of(sections);
    if (r.failed || attr_bytes < 0 || h->row >= tiling->rows || h->col >= tiling->cols ||
        h->encoding >= DX_N_ENCODINGS)
        return -EBADMSG;
    h->attr_bytes = (uint8_t)attr_bytes;
    h->has_normals = sections & DX_CHUNK_NORMALS;
    h->smoothed = sections & DX_CHUNK_SMOOTHED;
    if (h->n_triangles == 0)
        return h->n_vertices == 0 && sections == 0 && len == DX_CHUNK_HEADER_LEN ? 0 : -EBADMSG;
    if (h->n_triangles > DX_TILE_MAX_TRIANGLES || h->n_vertices < 3 ||
        h->n_vertices > DX_TILE_MAX_VERTICES)
        return -EBADMSG;
    return 0;
}

/* ---- sections ------------------------------------------------------------------------------- */

/* What lies between the header and the end: attributes, the encoding's part, normals. */
struct sections {
    const uint8_t *attr, *part, *normals;
    size_t part_len;
};

static int cut_sections(struct sections *s, const struct dx_chunk_header *h, const uint8_t *body,
                        size_t len)
{
    const size_t attr_len = (size_t)h->attr_bytes * h->n_vertices;
    const size_t normals_len = h->has_normals ? 2 * (size_t)h->n_vertices : 0;

    if (len < DX_CHUNK_HEADER_LEN + attr_len + normals_len)
        return -EBADMSG;
    s->attr = body + DX_CHUNK_HEADER_LEN;
    s->part = s->attr + attr_len;
    s->normals = body + len - normals_len;
    s->part_len = (size_t)(s->normals - s->part);
    return 0;
}

static int get_normals(int8_t *normal, const uint8_t *p, size_t n)
{
    memcpy(normal, p, 2 * n);
    for (size_t i = 0; i < 2 * n; i++)
        if (normal[i] < -DX_OCTAHEDRAL_MAX)
            return -EBADMSG;
    return 0;
}

static void get_attrs(uint16_t *attr, const uint8_t *p, uint32_t n, uint8_t attr_bytes)
{
    if (attr_bytes == 2)
        dx_get_u16s(attr, p, n);
    for (uint32_t i = 0; attr_bytes == 1 && i < n; i++)
        attr[i] = p[i];
}

/* ---- f32 ------------------------------------------------------------------------------------ */

/* Counts the mask's dexels; -EBADMSG when one is outside the grid. */
static int count_mask(const struct dx_tile_mesh *mesh, const struct dx_tiling *tiling)
{
    int n = 0;

    for (uint32_t byte = 0; byte < DX_MASK_BYTES; byte++) {
        for (uint32_t bits = mesh->mask[byte]; bits; bits &= bits - 1) {
            const uint32_t k = 8 * byte + (uint32_t)__builtin_ctz(bits);

            if (!dx_chunk_in_grid(tiling, mesh->row, mesh->col, (int)(k / DX_BLOCK),
                                  (int)(k % DX_BLOCK)))
                return -EBADMSG;
            n++;
        }
    }
    return n;
}

static int get_f32(struct dx_tile_mesh *mesh, const struct sections *s,
                   const struct dx_tiling *tiling)
{
    const uint32_t n = mesh->n_vertices, n_index = 3u * mesh->n_triangles;
    const uint8_t *p = s->part;
    uint32_t highest = 0;

    if (s->part_len != DX_MASK_BYTES + 12 * (size_t)n + 2 * (size_t)n_index)
        return -EBADMSG;
    memcpy(mesh->mask, p, DX_MASK_BYTES);
    if (count_mask(mesh, tiling) != (int)n)
        return -EBADMSG;
    p += DX_MASK_BYTES;
    dx_get_f32s(mesh->xyz, p, 3 * (size_t)n);
    p += 12 * (size_t)n;
    dx_get_u16s(mesh->index, p, n_index);
    for (uint32_t i = 0; i < n_index; i++)
        highest = mesh->index[i] > highest ? mesh->index[i] : highest;
    if (highest >= n)
        return -EBADMSG;
    get_attrs(mesh->attr, s->attr, n, mesh->attr_bytes);
    return mesh->has_normals ? get_normals(mesh->normal, s->normals, n) : 0;
}

/* ---- q16 and delta: a tile, and the mesh from it -------------------------------------------- */

/* Codes of q16 into `tile`. */
static const uint8_t *get_codes(struct dx_tile *tile, const uint8_t *p, const uint8_t *end)
{
    struct dx_bit_reader b = dx_bit_reader_init(p, end);

    for (uint32_t i = 0; i < tile->cell_rows; i++) {
        uint8_t *code = tile->code + DX_TILE_CELLS * i;

        for (uint32_t j = 0; j < tile->cell_cols; j += 8) {
            const uint32_t left = tile->cell_cols - j, n = left < 8 ? left : 8;
            uint32_t bits = dx_get_bits(&b, 3 * n);

            for (uint32_t m = 0; m < n; m++, bits >>= 3) {
                code[j + m] = bits & 7;
                if (code[j + m] > DX_CELL_ABD_BCD)
                    return NULL;
            }
        }
    }
    return dx_finish_bits(&b);
}

/* Ranges of q16, to where `used` puts them. */
static const uint8_t *get_ranges(struct dx_tile *tile, const struct dx_used *used, const uint8_t *p,
                                 const uint8_t *end)
{
    if ((size_t)(end - p) < 2 * (size_t)dx_used_count(used))
        return NULL;
    for (uint32_t i = 0; i < DX_BLOCK; i++)
        for (dx_bits row = used->row[i]; row; row &= row - 1, p += 2) {
            uint32_t *range = &tile->range[i * DX_BLOCK + dx_bits_first(row)];

            *range = dx_get_u16(p);
            if (*range == 0)
                return NULL;
        }
    return p;
}

/* Attributes and normals, from rank order to block order. */
static int get_samples(struct dx_tile *tile, const struct dx_used *used, const struct sections *s)
{
    const uint8_t *attr = s->attr, *normal = s->normals;

    for (uint32_t k = 0; (tile->attr_bytes || tile->has_normals) && k < DX_BLOCK_DEXELS; k++) {
        if (!dx_used_has(used, k))
            continue;
        if (tile->attr_bytes)
            tile->attr[k] = tile->attr_bytes == 2 ? dx_get_u16(attr) : *attr;
        attr += tile->attr_bytes;
        if (!tile->has_normals)
            continue;
        if (get_normals(tile->normal + 2 * k, normal, 1) < 0)
            return -EBADMSG;
        normal += 2;
    }
    return 0;
}

static int get_tile(struct dx_tile *tile, const struct dx_chunk_header *h, const struct sections *s,
                    const struct dx_tiling *tiling)
{
    const bool delta = h->encoding == DX_ENCODING_DELTA;
    const uint8_t *p = s->part, *end = s->part + s->part_len;
    uint32_t n_triangles = 0;
    struct dx_used used;

    p = delta ? dx_delta_get_codes(tile, p, end) : get_codes(tile, p, end);
    if (p)
        p = dx_chunk_get_struts(tile, p, end, tiling, &n_triangles);
    if (!p)
        return -EBADMSG;
    n_triangles += dx_rows_get(DX_SIMD_AUTO)->count_triangles(tile->code, DX_TILE_CELLS);
    if (n_triangles != h->n_triangles)
        return -EBADMSG;
    dx_used_mark(&used, tile->code, tile->strut);
    if (dx_used_count(&used) != h->n_vertices)
        return -EBADMSG;
    p = delta ? dx_delta_get_ranges(tile, &used, p, end) : get_ranges(tile, &used, p, end);
    return p == end ? get_samples(tile, &used, s) : -EBADMSG;
}

static int get_ranged(struct dx_tile_mesh *mesh, const struct dx_chunk_header *h,
                      const struct sections *s, const struct dx_tiling *tiling,
                      const struct dx_geometry *g)
{
    struct dx_tile tile = {.row = h->row,
                           .col = h->col,
                           .attr_bytes = h->attr_bytes,
                           .has_normals = h->has_normals,
                           .cell_rows = (uint8_t)cells_of(tiling->cell_rows, h->row),
                           .cell_cols = (uint8_t)cells_of(tiling->cell_cols, h->col)};
    int r = g ? get_tile(&tile, h, s, tiling) : -EBADMSG;

    if (r == 0)
        dx_tile_mesh_build(mesh, &tile, tiling, g);
    return r;
}

int dx_chunk_get(struct dx_tile_mesh *mesh, const uint8_t *body, size_t len,
                 const struct dx_tiling *tiling, const struct dx_geometry *g)
{
    struct dx_chunk_header h;
    struct sections s;
    int r = dx_chunk_get_header(&h, body, len, tiling);

    if (r == 0)
        r = cut_sections(&s, &h, body, len);
    if (r < 0)
        return r;
    mesh->row = h.row;
    mesh->col = h.col;
    mesh->attr_bytes = h.attr_bytes;
    mesh->has_normals = h.has_normals;
    mesh->n_vertices = h.n_vertices;
    mesh->n_triangles = h.n_triangles;
    if (h.n_triangles == 0) {
        memset(mesh->mask, 0, DX_MASK_BYTES);
        return 0;
    }
    return h.encoding == DX_ENCODING_F32 ? get_f32(mesh, &s, tiling)
                                         : get_ranged(mesh, &h, &s, tiling, g);
}
