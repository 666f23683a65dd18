/*
 * Chunk encoders: the last step of the frame path before the socket, called by pool threads on
 * memory of the feed's arena. Pure functions.
 */
#include "core/wire/chunk.h"

static const uint8_t sections_of[3] = {0, DX_CHUNK_ATTR8, DX_CHUNK_ATTR16};

size_t dx_chunk_max_len(enum dx_encoding encoding)
{
    const size_t codes = (3 * DX_TILE_CELLS * DX_TILE_CELLS + 7) / 8;
    const size_t f32 = DX_MASK_BYTES + 12 * DX_TILE_MAX_VERTICES + 6 * DX_TILE_MAX_TRIANGLES;
    const size_t q16 = codes + 2 * DX_TILE_MAX_VERTICES;

    return DX_CHUNK_HEADER_LEN + (encoding == DX_ENCODING_F32 ? f32 : q16) +
           2 * DX_TILE_MAX_VERTICES;
}

static uint8_t *put_header(uint8_t *out, const struct dx_chunk_header *h)
{
    dx_put_u16(out, h->row);
    dx_put_u16(out + 2, h->col);
    out[4] = h->encoding;
    out[5] = sections_of[h->attr_bytes];
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

static uint8_t *put_attr8(uint8_t *p, const uint16_t *attr, size_t n)
{
    for (size_t i = 0; i < n; i++)
        p[i] = (uint8_t)attr[i];
    return p + n;
}

size_t dx_chunk_put_f32(uint8_t *out, const struct dx_tile_mesh *mesh)
{
    const struct dx_chunk_header h = {.row = mesh->row,
                                      .col = mesh->col,
                                      .encoding = DX_ENCODING_F32,
                                      .attr_bytes = mesh->attr_bytes,
                                      .n_vertices = (uint16_t)mesh->n_vertices,
                                      .n_triangles = (uint16_t)mesh->n_triangles};
    const size_t n = mesh->n_vertices;
    uint8_t *p;

    if (mesh->n_triangles == 0)
        return dx_chunk_put_empty(out, DX_ENCODING_F32, mesh->row, mesh->col);
    p = put_header(out, &h);
    memcpy(p, mesh->mask, DX_MASK_BYTES);
    p += DX_MASK_BYTES;
    dx_put_f32s(p, mesh->xyz, 3 * n);
    p += 12 * n;
    dx_put_u16s(p, mesh->index, 3 * (size_t)mesh->n_triangles);
    p += 6 * (size_t)mesh->n_triangles;
    if (mesh->attr_bytes == 1) {
        p = put_attr8(p, mesh->attr, n);
    } else if (mesh->attr_bytes == 2) {
        dx_put_u16s(p, mesh->attr, n);
        p += 2 * n;
    }
    return (size_t)(p - out);
}

/* Least significant bits first. */
struct bit_writer {
    uint8_t *p;
    uint64_t bits;
    unsigned n;
};

static inline void put_bits(struct bit_writer *b, uint32_t v, unsigned n)
{
    b->bits |= (uint64_t)v << b->n;
    for (b->n += n; b->n >= 8; b->n -= 8) {
        *b->p++ = (uint8_t)b->bits;
        b->bits >>= 8;
    }
}

/* Eight codes, one a byte, to 24 bits. */
static inline uint32_t pack8(uint64_t x)
{
    x = (x | x >> 5) & 0x003f003f003f003fu;
    x = (x | x >> 10) & 0x00000fff00000fffu;
    return (uint32_t)((x | x >> 20) & 0xffffffu);
}

/* Triangles of eight codes, one a byte: one for each code but 0, one more for 3 and 6. */
static inline uint32_t count8(uint64_t x)
{
    const uint64_t ones = 0x0101010101010101u;
    uint64_t some = (x | x >> 1 | x >> 2) & ones, two = (x >> 1) & (x ^ x >> 2) & ones;

    return (uint32_t)(((some + two) * ones) >> 56);
}

static uint8_t *put_codes(uint8_t *out, const struct dx_tile *tile, uint32_t *n_triangles)
{
    struct bit_writer b = {out, 0, 0};
    uint32_t n = 0;

    for (uint32_t i = 0; i < tile->cell_rows; i++) {
        const uint8_t *code = tile->code + DX_TILE_CELLS * i;

        /* The codes beyond cell_cols are 0, and the stride is a multiple of eight. */
        for (uint32_t j = 0; j < tile->cell_cols; j += 8) {
            const uint32_t left = tile->cell_cols - j;
            const uint64_t x = dx_get_u64(code + j);

            put_bits(&b, pack8(x), 3 * (left < 8 ? left : 8));
            n += count8(x);
        }
    }
    if (b.n)
        *b.p++ = (uint8_t)b.bits;
    *n_triangles = n;
    return b.p;
}

static uint8_t *put_ranges(uint8_t *p, const struct dx_tile *tile, const uint8_t *mask)
{
    for (uint32_t byte = 0; byte < DX_MASK_BYTES; byte++) {
        const uint32_t *range = tile->range + 8 * byte;
        uint32_t bits = mask[byte];

        if (bits == 0xff) {
            for (int i = 0; i < 8; i++)
                dx_put_u16(p + 2 * i, (uint16_t)range[i]);
            p += 16;
            continue;
        }
        for (; bits; bits &= bits - 1) {
            dx_put_u16(p, (uint16_t)range[__builtin_ctz(bits)]);
            p += 2;
        }
    }
    return p;
}

static uint8_t *put_attrs(uint8_t *p, const struct dx_tile *tile, const uint8_t *mask)
{
    for (uint32_t byte = 0; byte < DX_MASK_BYTES; byte++) {
        for (uint32_t bits = mask[byte]; bits; bits &= bits - 1) {
            const uint16_t v = tile->attr[8 * byte + (uint32_t)__builtin_ctz(bits)];

            *p++ = (uint8_t)v;
            if (tile->attr_bytes == 2)
                *p++ = (uint8_t)(v >> 8);
        }
    }
    return p;
}

size_t dx_chunk_put_q16(uint8_t *out, const struct dx_tile *tile)
{
    struct dx_chunk_header h = {.row = tile->row,
                                .col = tile->col,
                                .encoding = DX_ENCODING_Q16,
                                .attr_bytes = tile->attr_bytes};
    uint8_t mask[DX_MASK_BYTES];
    uint32_t n_triangles;
    uint8_t *p = put_codes(out + DX_CHUNK_HEADER_LEN, tile, &n_triangles);

    if (n_triangles == 0)
        return dx_chunk_put_empty(out, DX_ENCODING_Q16, tile->row, tile->col);
    h.n_vertices = (uint16_t)dx_tile_mask(tile, mask);
    h.n_triangles = (uint16_t)n_triangles;
    put_header(out, &h);
    p = put_ranges(p, tile, mask);
    if (tile->attr_bytes)
        p = put_attrs(p, tile, mask);
    return (size_t)(p - out);
}
