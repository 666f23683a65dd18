/*
 * From the codes of a tile to its triangles, and the hash of what it says. Shared by the daemon's
 * encoders and the client's decoders, so that both get the same bits.
 */
#include "core/grid/tile_used.h"

#include "core/base/bytes.h"
#include "core/base/hash.h"
#include "core/rows/rows.h"

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

static uint16_t *emit_strut(uint16_t *out, const uint16_t *rank, uint8_t code, bool flip)
{
    struct dx_strut_corner triangle[DX_STRUT_MAX_TRIANGLES][3];
    const unsigned n = dx_strut_triangles(triangle, code);

    for (unsigned t = 0; t < n; t++)
        for (int m = 0; m < 3; m++) {
            const struct dx_strut_corner c = triangle[t][flip && m ? 3 - m : m];

            *out++ = rank[c.row * DX_BLOCK + c.col];
        }
    return out;
}

/* Both triangles are written, and kept if they are there. */
static uint16_t *emit_lone(uint16_t *out, const uint16_t *rank, const struct dx_lone_strut *s,
                           bool flip)
{
    const int along = s->across ? 1 : DX_BLOCK, beside = s->across ? DX_BLOCK : 1;
    const uint16_t begin = rank[-along], end = rank[along];
    const bool turn = s->across == flip; /* of the first side; the second runs the other way */

    out[0] = begin;
    out[1 + turn] = rank[-beside];
    out[1 + !turn] = end;
    out += 3 * s->first;
    out[0] = begin;
    out[1 + !turn] = rank[beside];
    out[1 + turn] = end;
    return out + 3 * s->second;
}

static uint16_t *emit_struts(uint16_t *out, const struct dx_tile *tile,
                             const uint16_t rank[DX_BLOCK_DEXELS], bool flip)
{
    for (uint32_t k = dx_tile_next_strut(tile, 0); k < DX_BLOCK_DEXELS;
         k = dx_tile_next_strut(tile, k + 1)) {
        struct dx_lone_strut s;

        if (dx_strut_is_lone(&s, tile->strut[k]))
            out = emit_lone(out, rank + k, &s, flip);
        else
            out = emit_strut(out, rank + k, tile->strut[k], flip);
    }
    return out;
}

uint32_t dx_tile_emit(const struct dx_tile *tile, const uint16_t rank[DX_BLOCK_DEXELS], bool flip,
                      uint16_t *index)
{
    const struct dx_rows *rows = dx_rows_get(DX_SIMD_AUTO);
    uint16_t *out = index;

    for (uint32_t i = 0; i < tile->cell_rows; i++) { /* codes beyond cell_cols are 0 */
        const uint16_t *top = rank + (size_t)(i + 1) * DX_BLOCK + 1;

        out = rows->emit(out, tile->code + (size_t)i * DX_TILE_CELLS, top, top + DX_BLOCK, flip);
    }
    out = emit_struts(out, tile, rank, flip);
    return (uint32_t)(out - index) / 3;
}

/* Ranges that all fit 16 bits, as nearly all do, by their low halves alone. */
static uint64_t hash_ranges(uint64_t h, const struct dx_tile *tile, const struct dx_used *used)
{
    uint16_t low[DX_USED_ROOM];
    uint32_t high[DX_BLOCK_DEXELS];
    uint32_t all = dx_rows_get(DX_SIMD_AUTO)->halves(low, tile->range, used->at, DX_USED_ROOM / 8);

    h = dx_hash(h, low, sizeof(low));
    if (all >> 16 == 0)
        return h;
    for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
        high[k] = tile->range[k] >> 16 & -(uint32_t)used->at[k];
    return dx_hash(h, high, sizeof(high));
}

static uint64_t hash_samples(uint64_t h, const struct dx_tile *tile, const struct dx_used *used)
{
    uint16_t sample[DX_BLOCK_DEXELS];

    h = hash_ranges(h, tile, used);
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
