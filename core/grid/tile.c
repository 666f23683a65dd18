/*
 * From the codes of a tile to its triangles, and the hash of what it says. Shared by the daemon's
 * encoders and the client's decoders, so that both get the same bits.
 */
#include "core/grid/tile_used.h"

#include "core/base/bytes.h"
#include "core/base/hash.h"

#include <string.h>

void dx_tiling_init(struct dx_tiling *t, uint32_t height, uint32_t width, bool wrap)
{
    *t = (struct dx_tiling){.height = height, .width = width, .wrap = wrap};
    t->cell_rows = height ? height - 1 : 0;
    t->cell_cols = wrap || width == 0 ? width : width - 1;
    t->rows = (t->cell_rows + DX_TILE_CELLS - 1) / DX_TILE_CELLS;
    t->cols = (t->cell_cols + DX_TILE_CELLS - 1) / DX_TILE_CELLS;
}

uint32_t dx_tile_mask(const struct dx_tile *tile, uint8_t mask[DX_MASK_BYTES])
{
    struct dx_used used;
    uint32_t n = 0;

    dx_used_mark(&used, tile);
    dx_used_pack(&used, mask);
    for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
        n += used.at[k];
    return n;
}

/* Corners of the triangle of an outcome that has one: 0 a, 1 b, 2 c, 3 d; in index order, and
 * flipped. */
static const uint8_t corners[2][7][3] = {
    {[DX_CELL_ABC] = {0, 1, 2},
     [DX_CELL_ACD] = {0, 2, 3},
     [DX_CELL_ABD] = {0, 1, 3},
     [DX_CELL_BCD] = {1, 2, 3}},
    {[DX_CELL_ABC] = {0, 2, 1},
     [DX_CELL_ACD] = {0, 3, 2},
     [DX_CELL_ABD] = {0, 3, 1},
     [DX_CELL_BCD] = {1, 3, 2}},
};

static inline bool is_full(uint8_t code)
{
    return 1u << code & (1u << DX_CELL_ABC_ACD | 1u << DX_CELL_ABD_BCD);
}

/* Two indices by one store. */
static inline void put_pair(uint16_t *out, uint32_t first, uint32_t second)
{
    uint32_t pair = dx_host_is_little_endian() ? first | second << 16 : first << 16 | second;

    memcpy(out, &pair, sizeof(pair));
}

/* The two triangles of a full cell: abc, acd or abd, bcd. All its corners are used, so that b
 * follows a, and c follows d. No branch on the diagonal: noise makes that a coin toss. */
static inline void emit_full(uint16_t *out, uint8_t code, bool flip, uint32_t a, uint32_t d)
{
    uint32_t on_bd = code == DX_CELL_ABD_BCD, b = a + 1, c = d + 1;

    put_pair(out, a, flip ? c - on_bd : b);
    put_pair(out + 2, flip ? b : c - on_bd, a + on_bd);
    put_pair(out + 4, flip ? d : c, flip ? c : d);
}

/* Inlined with either orientation. */
static inline __attribute__((always_inline)) uint16_t *emit_row(uint16_t *out, const uint8_t *code,
                                                                uint32_t n, const uint16_t *top,
                                                                const uint16_t *bottom, bool flip)
{
    const uint8_t(*corner)[3] = corners[flip];

    for (uint32_t j = 0; j < n; j++) {
        if (is_full(code[j])) {
            emit_full(out, code[j], flip, top[j], bottom[j]);
            out += 6;
        } else if (code[j] != DX_CELL_NONE) {
            const uint16_t v[4] = {top[j], top[j + 1], bottom[j + 1], bottom[j]};

            for (int m = 0; m < 3; m++)
                *out++ = v[corner[code[j]][m]];
        }
    }
    return out;
}

static uint16_t *emit_struts(uint16_t *out, const struct dx_tile *tile,
                             const uint16_t rank[DX_BLOCK_DEXELS], bool flip)
{
    for (uint32_t k = dx_tile_next_strut(tile, 0); k < DX_BLOCK_DEXELS;
         k = dx_tile_next_strut(tile, k + 1)) {
        struct dx_strut_corner triangle[DX_STRUT_MAX_TRIANGLES][3];
        unsigned n = dx_strut_triangles(triangle, tile->strut[k]);

        for (unsigned t = 0; t < n; t++) {
            const struct dx_strut_corner *p = triangle[t];

            *out++ = rank[dx_tile_strut_corner(k, p[0])];
            *out++ = rank[dx_tile_strut_corner(k, p[flip ? 2 : 1])];
            *out++ = rank[dx_tile_strut_corner(k, p[flip ? 1 : 2])];
        }
    }
    return out;
}

uint32_t dx_tile_emit(const struct dx_tile *tile, const uint16_t rank[DX_BLOCK_DEXELS], bool flip,
                      uint16_t *index)
{
    uint16_t *out = index;

    for (uint32_t i = 0; i < tile->cell_rows; i++) {
        const uint8_t *code = tile->code + (size_t)i * DX_TILE_CELLS;
        const uint16_t *top = rank + (size_t)(i + 1) * DX_BLOCK + 1, *bottom = top + DX_BLOCK;

        if (flip)
            out = emit_row(out, code, tile->cell_cols, top, bottom, true);
        else
            out = emit_row(out, code, tile->cell_cols, top, bottom, false);
    }
    out = emit_struts(out, tile, rank, flip);
    return (uint32_t)(out - index) / 3;
}

static uint64_t hash_samples(uint64_t h, const struct dx_tile *tile, const struct dx_used *used)
{
    uint32_t range[DX_BLOCK_DEXELS];
    uint16_t sample[DX_BLOCK_DEXELS];

    for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
        range[k] = tile->range[k] & -(uint32_t)used->at[k];
    h = dx_hash(h, range, sizeof(range));
    if (tile->attr_bytes) {
        for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
            sample[k] = (uint16_t)(tile->attr[k] & -used->at[k]);
        h = dx_hash(h, sample, sizeof(sample));
    }
    if (tile->has_normals) {
        for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
            sample[k] =
                (uint16_t)(((uint8_t)tile->normal[2 * k] | (uint8_t)tile->normal[2 * k + 1] << 8) &
                           -used->at[k]);
        h = dx_hash(h, sample, sizeof(sample));
    }
    return h;
}

/* By their bits: -0 is another point than 0. */
static uint64_t hash_points(uint64_t h, const struct dx_tile *tile, const struct dx_used *used)
{
    uint32_t bits[3 * DX_BLOCK_DEXELS];

    for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
        for (uint32_t m = 3 * k; m < 3 * k + 3; m++)
            bits[m] = dx_f32_bits(tile->xyz[m]) & -(uint32_t)used->at[k];
    return dx_hash(h, bits, sizeof(bits));
}

uint64_t dx_tile_hash(const struct dx_tile *tile)
{
    static const uint64_t seed =
        0x7465727261696e; /* so that no tile with triangles hashes to 0 by design */
    struct dx_used used;
    uint64_t h;

    dx_used_mark(&used, tile);
    h = dx_hash(seed, tile->code, sizeof(tile->code));
    if (dx_tile_next_strut(tile, 0) < DX_BLOCK_DEXELS) /* most tiles have none: nothing to pay */
        h = dx_hash(h, tile->strut, sizeof(tile->strut));
    h = hash_samples(h, tile, &used);
    if (tile->exact)
        h = hash_points(h, tile, &used);
    return h | 1; /* 0 is kept for tiles without triangles */
}
