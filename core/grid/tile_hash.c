/* Ranges by rows, in vectors (rows.h: digest); all else by dx_hash. */
#include "core/grid/tile_hash.h"

#include "core/base/bytes.h"
#include "core/base/hash.h"
#include "core/grid/tile_used.h"

#include <assert.h>
#include <string.h>

/* Rows of ranges so far. */
struct digest {
    const struct dx_rows *rows;
    uint64_t lane[DX_ROWS_LANES];
    uint64_t n_rows;
};

/* Ranges that all fit 16 bits, as nearly all do, by their low halves alone. */
static void add_wide(struct digest *d, const uint32_t *range, dx_bits used)
{
    uint16_t low[DX_ROWS_N], high[DX_ROWS_N];
    const uint16_t *const row[2] = {low, high};
    dx_bits each[2] = {used, 0};

    for (uint32_t j = 0; j < DX_ROWS_N; j++) {
        low[j] = (uint16_t)range[j];
        high[j] = (uint16_t)(range[j] >> 16);
    }
    each[1] = d->rows->valid(high) & used;
    d->rows->digest(d->lane, row, each, each[1] ? 2 : 1);
    d->n_rows += each[1] ? 2 : 1;
}

/* The rows of a block, which begins one before the tile's cells. */
static void add_area(struct digest *d, const struct dx_area *a, const dx_bits used[DX_BLOCK])
{
    const uint32_t p0 = DX_MARGIN - 1, q0 = DX_MARGIN - 1;
    const uint16_t *row[DX_BLOCK];

    for (uint32_t i = 0; i < DX_BLOCK; i++) {
        row[i] = a->range16[p0 + i] + q0;
        if (a->wide)
            add_wide(d, a->range[p0 + i] + q0, used[i]);
    }
    if (a->wide)
        return;
    d->rows->digest(d->lane, row, used, DX_BLOCK);
    d->n_rows += DX_BLOCK;
}

/* What the codes say, and then all rows. */
static uint64_t end(struct digest *d, const uint64_t bit[3][DX_TILE_CELLS], const uint8_t *strut,
                    const struct dx_used *used)
{
    uint64_t word[3 * DX_TILE_CELLS / DX_ROWS_LANES][DX_ROWS_LANES], h = d->n_rows;

    static_assert(sizeof(word) == 3 * DX_TILE_CELLS * sizeof(uint64_t), "whole rows");
    memcpy(word, bit, sizeof(word));
    d->rows->digest_words(d->lane, word, 3 * DX_TILE_CELLS / DX_ROWS_LANES);
    if (used->has_struts) /* most tiles have none: nothing to pay */
        h = dx_hash(h, strut, DX_BLOCK_DEXELS);
    for (uint32_t k = 0; k < DX_ROWS_LANES; k++)
        h = dx_hash_u64(h, d->lane[k]);
    return h;
}

uint64_t dx_tile_hash_outcome(const struct dx_outcome *out, const struct dx_rules_scratch *made,
                              const struct dx_rows *rows)
{
    struct digest d = {.rows = rows};
    struct dx_used used;

    dx_used_of(&used, made->cells.bit, *out->has_struts ? out->strut : NULL);
    if (dx_used_count(&used) == 0)
        return 0;
    add_area(&d, &made->area, used.row);
    return end(&d, made->cells.bit, out->strut, &used) | 1;
}

/* ---- more than codes and ranges ------------------------------------------------------------- */

static void add_samples(struct digest *d, const uint16_t sample[DX_BLOCK_DEXELS + 16],
                        const struct dx_used *used)
{
    const uint16_t *row[DX_BLOCK];

    for (uint32_t i = 0; i < DX_BLOCK; i++)
        row[i] = sample + (size_t)i * DX_BLOCK;
    d->rows->digest(d->lane, row, used->row, DX_BLOCK);
    d->n_rows += DX_BLOCK;
}

static void add_normals(struct digest *d, const struct dx_tile *tile, const struct dx_used *used)
{
    uint16_t sample[DX_BLOCK_DEXELS + 16] = {0};

    for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
        sample[k] = dx_get_u16((const uint8_t *)tile->normal + 2 * (size_t)k);
    add_samples(d, sample, used);
}

/* By their bits: -0 is another point than 0. */
static uint64_t hash_points(uint64_t h, const struct dx_tile *tile, const struct dx_used *used)
{
    uint32_t bits[3 * DX_BLOCK_DEXELS];

    for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
        for (uint32_t m = 3 * k; m < 3 * k + 3; m++)
            bits[m] = dx_used_has(used, k) ? dx_f32_bits(tile->xyz[m]) : 0;
    return dx_hash(h, bits, sizeof(bits));
}

uint64_t dx_tile_hash(const struct dx_tile *tile)
{
    struct digest d = {.rows = dx_rows_get(DX_SIMD_AUTO)};
    uint64_t bit[3][DX_TILE_CELLS], h;
    struct dx_used used;

    dx_used_bits(bit, tile->code);
    dx_used_of(&used, bit, tile->strut);
    if (dx_used_count(&used) == 0)
        return 0;
    for (uint32_t i = 0; i < DX_BLOCK; i++)
        add_wide(&d, tile->range + (size_t)i * DX_BLOCK, used.row[i]);
    if (tile->attr_bytes)
        add_samples(&d, tile->attr, &used);
    if (tile->has_normals)
        add_normals(&d, tile, &used);
    h = end(&d, bit, tile->strut, &used);
    if (tile->exact)
        h = hash_points(h, tile, &used);
    return h | 1;
}
