/*
 * Chunk encoders: the last step of the frame path before the socket, called by pool threads on
 * memory of the feed's arena. Pure functions.
 */
#include "core/base/codes.h"
#include "core/rows/rows.h"
#include "core/wire/bits.h"
#include "core/wire/chunk_parts.h"

static const uint8_t attr_section[3] = {0, DX_CHUNK_ATTR8, DX_CHUNK_ATTR16};

/* Longest parts; DX_CHUNK_STRUTS_MAX says why struts and ranges add up so. */
static size_t longest_part(enum dx_encoding encoding)
{
    const size_t groups = DX_TILE_CELLS * DX_TILE_CELLS / 8;
    const size_t blocks = (DX_TILE_MAX_VERTICES + 31) / 32;

    switch (encoding) {
    case DX_ENCODING_F32:
        return DX_MASK_BYTES + 12 * DX_TILE_MAX_VERTICES + 6 * DX_TILE_MAX_TRIANGLES;
    case DX_ENCODING_Q16: /* three bits a cell */
        return 3 * groups + DX_CHUNK_STRUTS_MAX + 2 * DX_TILE_MAX_VERTICES;
    default: /* three bits more a group; 32 bits a residual, and up to 65 more a block */
        return (27 * groups + 7) / 8 + DX_CHUNK_STRUTS_MAX + 5 + 4 * DX_TILE_MAX_VERTICES +
               (65 * blocks + 7) / 8;
    }
}

size_t dx_chunk_max_len(enum dx_encoding encoding)
{
    const size_t attr = 2 * DX_TILE_MAX_VERTICES, normals = 2 * DX_TILE_MAX_VERTICES;

    return DX_CHUNK_HEADER_LEN + attr + longest_part(encoding) + normals;
}

static uint8_t *put_header(uint8_t *out, const struct dx_chunk_header *h)
{
    dx_put_u16(out, h->row);
    dx_put_u16(out + 2, h->col);
    out[4] = h->encoding;
    out[DX_CHUNK_SECTIONS_AT] =
        (uint8_t)(attr_section[h->attr_bytes] | (h->has_normals ? DX_CHUNK_NORMALS : 0));
    dx_put_u16(out + 6, h->n_vertices);
    dx_put_u16(out + 8, h->n_triangles);
    return out + DX_CHUNK_HEADER_LEN;
}

size_t dx_chunk_put_empty(uint8_t *out, enum dx_encoding encoding, uint32_t tile_row,
                          uint32_t tile_col)
{
    const struct dx_chunk_header h = {
        .row = (uint16_t)tile_row, .col = (uint16_t)tile_col, .encoding = (uint8_t)encoding};

    return (size_t)(put_header(out, &h) - out);
}

void dx_chunk_set_smoothed(uint8_t *chunk)
{
    if (dx_get_u16(chunk + DX_CHUNK_TRIANGLES_AT))
        chunk[DX_CHUNK_SECTIONS_AT] |= DX_CHUNK_SMOOTHED;
}

void dx_chunk_cut(struct dx_chunk_cut *cut, const uint8_t *header, uint32_t len, uint8_t keep)
{
    const uint8_t drop = header[DX_CHUNK_SECTIONS_AT] & (uint8_t)~keep;
    const uint32_t n = dx_get_u16(header + 6);

    memcpy(cut->head, header, DX_CHUNK_HEADER_LEN);
    cut->head[DX_CHUNK_SECTIONS_AT] &= keep | DX_CHUNK_SMOOTHED;
    cut->skip = DX_CHUNK_HEADER_LEN;
    if (drop & (DX_CHUNK_ATTR8 | DX_CHUNK_ATTR16))
        cut->skip += drop & DX_CHUNK_ATTR16 ? 2 * n : n;
    cut->len = len - cut->skip - (drop & DX_CHUNK_NORMALS ? 2 * n : 0);
}

/* ---- a mesh as f32
 * ------------------------------------------------------------------------------------ */

static uint8_t *put_attrs(uint8_t *p, const uint16_t *attr, size_t n, uint8_t attr_bytes)
{
    if (attr_bytes == 2)
        dx_put_u16s(p, attr, n);
    for (size_t i = 0; attr_bytes == 1 && i < n; i++)
        p[i] = (uint8_t)attr[i];
    return p + n * attr_bytes;
}

size_t dx_chunk_put_mesh(uint8_t *out, const struct dx_tile_mesh *mesh)
{
    const struct dx_chunk_header h = {.row = mesh->row,
                                      .col = mesh->col,
                                      .encoding = DX_ENCODING_F32,
                                      .attr_bytes = mesh->attr_bytes,
                                      .has_normals = mesh->has_normals,
                                      .n_vertices = (uint16_t)mesh->n_vertices,
                                      .n_triangles = (uint16_t)mesh->n_triangles};
    const size_t n = mesh->n_vertices;
    uint8_t *p;

    if (mesh->n_triangles == 0)
        return dx_chunk_put_empty(out, DX_ENCODING_F32, mesh->row, mesh->col);
    p = put_attrs(put_header(out, &h), mesh->attr, n, mesh->attr_bytes);
    memcpy(p, mesh->mask, DX_MASK_BYTES);
    p += DX_MASK_BYTES;
    dx_put_f32s(p, mesh->xyz, 3 * n);
    p += 12 * n;
    dx_put_u16s(p, mesh->index, 3 * (size_t)mesh->n_triangles);
    p += 6 * (size_t)mesh->n_triangles;
    if (mesh->has_normals) {
        memcpy(p, mesh->normal, 2 * n);
        p += 2 * n;
    }
    return (size_t)(p - out);
}

/* ---- a tile as it is --------------------------------------------------------- */

static uint8_t *put_codes(uint8_t *out, const struct dx_tile *tile)
{
    struct dx_bit_writer b = {out, 0, 0};

    if (tile->cell_cols == DX_TILE_CELLS) { /* whole bytes; the next part mends what is too much */
        dx_rows_get(DX_SIMD_AUTO)->pack_codes(out, tile->code, tile->cell_rows);
        return out + tile->cell_rows * (size_t)(3 * DX_TILE_CELLS / 8);
    }
    for (uint32_t i = 0; i < tile->cell_rows; i++) {
        const uint8_t *code = tile->code + DX_TILE_CELLS * i;

        /* The codes beyond cell_cols are 0, and the stride is a multiple of eight. */
        for (uint32_t j = 0; j < tile->cell_cols; j += 8) {
            const uint32_t left = tile->cell_cols - j;

            dx_put_bits(&b, (uint32_t)dx_codes_pack8(dx_get_u64(code + j)),
                        3 * (left < 8 ? left : 8));
        }
    }
    return dx_end_bits(&b);
}

/* Values of the used dexels, 16 bits each, one after the other; `kept` has the room. */
static size_t keep_used(uint16_t *kept, const uint32_t *value, const struct dx_used *used)
{
    const struct dx_rows *rows = dx_rows_get(DX_SIMD_AUTO);
    uint16_t *end = kept;

    for (uint32_t i = 0; i < DX_BLOCK; i++)
        end = rows->keep16(end, value + (size_t)i * DX_BLOCK, used->row[i]);
    return (size_t)(end - kept);
}

static uint8_t *put_ranges(uint8_t *p, const struct dx_tile *tile, const struct dx_used *used)
{
    uint16_t kept[DX_BLOCK_DEXELS + DX_ROWS_SLACK];
    const size_t n = keep_used(kept, tile->range, used);

    dx_put_u16s(p, kept, n);
    return p + 2 * n;
}

static uint8_t *put_tile_attrs(uint8_t *p, const struct dx_tile *tile, const struct dx_used *used)
{
    uint16_t kept[DX_BLOCK_DEXELS + DX_ROWS_SLACK];
    uint32_t value[DX_BLOCK_DEXELS + 16];

    if (tile->attr_bytes == 0)
        return p;
    dx_rows_get(DX_SIMD_AUTO)->widen(value, tile->attr, DX_BLOCK, DX_BLOCK);
    return put_attrs(p, kept, keep_used(kept, value, used), tile->attr_bytes);
}

static uint8_t *put_tile_normals(uint8_t *p, const struct dx_tile *tile, const struct dx_used *used)
{
    for (uint32_t i = 0; tile->has_normals && i < DX_BLOCK; i++)
        for (dx_bits row = used->row[i]; row; row &= row - 1, p += 2)
            memcpy(p, tile->normal + 2 * (i * DX_BLOCK + dx_bits_first(row)), 2);
    return p;
}

static uint32_t count_triangles(const struct dx_tile *tile, const struct dx_used *used)
{
    uint32_t n = dx_rows_get(DX_SIMD_AUTO)->count_triangles(tile->code, tile->cell_rows);

    for (uint32_t i = 0; used->has_struts && i < DX_BLOCK; i++)
        for (dx_bits row = used->strut[i]; row; row &= row - 1) {
            const uint8_t code = tile->strut[i * DX_BLOCK + dx_bits_first(row)];
            struct dx_strut_corner triangle[DX_STRUT_MAX_TRIANGLES][3];
            struct dx_lone_strut s;

            n += dx_strut_is_lone(&s, code) ? (uint32_t)s.first + s.second
                                            : dx_strut_triangles(triangle, code);
        }
    return n;
}

static struct dx_chunk_header header_of(const struct dx_tile *tile, enum dx_encoding encoding,
                                        const struct dx_used *used)
{
    return (struct dx_chunk_header){.row = tile->row,
                                    .col = tile->col,
                                    .encoding = (uint8_t)encoding,
                                    .attr_bytes = tile->attr_bytes,
                                    .has_normals = tile->has_normals,
                                    .n_vertices = (uint16_t)dx_used_count(used)};
}

/* Points and indices are made where they belong. What is written too much behind them
 * (DX_ROWS_SLACK) the next part mends; behind the last one is the room of attributes and normals
 * that are not there. */
size_t dx_chunk_put_f32(uint8_t *out, const struct dx_tile *tile, const struct dx_tiling *tiling,
                        const struct dx_geometry *g)
{
    struct dx_chunk_header h;
    struct dx_used used;
    size_t n_indices;
    uint8_t *p;

    dx_used_mark(&used, tile->code, tile->strut);
    h = header_of(tile, DX_ENCODING_F32, &used);
    if (h.n_vertices == 0)
        return dx_chunk_put_empty(out, DX_ENCODING_F32, tile->row, tile->col);
    p = put_tile_attrs(out + DX_CHUNK_HEADER_LEN, tile, &used);
    dx_used_pack(&used, p);
    p += DX_MASK_BYTES;
    dx_tile_points(tile, &used, tiling, g, (dx_packed_f32 *)p);
    dx_order_f32s(p, 3 * (size_t)h.n_vertices);
    p += 12 * (size_t)h.n_vertices;
    h.n_triangles = (uint16_t)dx_tile_emit(tile, &used, g->flip, (dx_packed_u16 *)p);
    n_indices = 3 * (size_t)h.n_triangles;
    dx_order_u16s(p, n_indices);
    put_header(out, &h);
    return (size_t)(put_tile_normals(p + 2 * n_indices, tile, &used) - out);
}

static size_t put_tile(uint8_t *out, const struct dx_tile *tile, enum dx_encoding encoding)
{
    struct dx_chunk_header h;
    struct dx_used used;
    uint8_t *p;

    dx_used_mark(&used, tile->code, tile->strut);
    h = header_of(tile, encoding, &used);
    if (h.n_vertices == 0)
        return dx_chunk_put_empty(out, encoding, tile->row, tile->col);
    h.n_triangles = (uint16_t)count_triangles(tile, &used);
    p = put_tile_attrs(put_header(out, &h), tile, &used);
    if (encoding == DX_ENCODING_Q16) {
        p = dx_chunk_put_struts(put_codes(p, tile), tile, &used);
        p = put_ranges(p, tile, &used);
    } else {
        p = dx_chunk_put_struts(dx_delta_put_codes(p, tile), tile, &used);
        p = dx_delta_put_ranges(p, tile, &used);
    }
    return (size_t)(put_tile_normals(p, tile, &used) - out);
}

size_t dx_chunk_put_q16(uint8_t *out, const struct dx_tile *tile)
{
    return put_tile(out, tile, DX_ENCODING_Q16);
}

size_t dx_chunk_put_delta(uint8_t *out, const struct dx_tile *tile)
{
    return put_tile(out, tile, DX_ENCODING_DELTA);
}
