/* Ranges by rows, in vectors (rows.h: digest); all else by dx_hash. */
#include "core/grid/tile_hash.h"

#include "core/base/bytes.h"
#include "core/base/hash.h"
#include "core/grid/tile_used.h"

/* Rows of ranges so far. */
struct digest {
    const struct dx_rows *rows;
    uint64_t lane[DX_ROWS_LANES];
    uint64_t n_rows;
};

static void add_narrow(struct digest *d, const uint16_t *range, dx_bits used)
{
    d->rows->digest(d->lane, range, used);
    d->n_rows++;
}

/* Ranges that all fit 16 bits, as nearly all do, by their low halves alone. */
static void add_wide(struct digest *d, const uint32_t *range, dx_bits used)
{
    uint16_t low[DX_ROWS_N], high[DX_ROWS_N];
    dx_bits is_high = 0;

    for (uint32_t j = 0; j < DX_ROWS_N; j++) {
        low[j] = (uint16_t)range[j];
        high[j] = (uint16_t)(range[j] >> 16);
    }
    add_narrow(d, low, used);
    is_high = d->rows->valid(high) & used;
    if (is_high)
        add_narrow(d, high, is_high);
}

/* What the codes say, and then all rows. */
static uint64_t end(const struct digest *d, const uint8_t *code, const uint8_t *strut,
                    const struct dx_used *used)
{
    uint64_t h = dx_hash(d->n_rows, code, DX_TILE_CELLS * DX_TILE_CELLS);

    if (used->has_struts) /* most tiles have none: nothing to pay */
        h = dx_hash(h, strut, DX_BLOCK_DEXELS);
    for (uint32_t k = 0; k < DX_ROWS_LANES; k++)
        h = dx_hash_u64(h, d->lane[k]);
    return h;
}

uint64_t dx_tile_hash_outcome(const struct dx_outcome *out, const struct dx_area *a,
                              const struct dx_rows *rows)
{
    struct digest d = {.rows = rows};
    struct dx_used used;

    dx_used_mark(&used, out->code, out->strut);
    if (dx_used_count(&used) == 0)
        return 0;
    for (uint32_t i = 0; i < DX_BLOCK; i++) { /* the block begins one before the tile's cells */
        const uint32_t p = DX_MARGIN - 1 + i, q = DX_MARGIN - 1;

        if (a->wide)
            add_wide(&d, a->range[p] + q, used.row[i]);
        else
            add_narrow(&d, a->range16[p] + q, used.row[i]);
    }
    return end(&d, out->code, out->strut, &used) | 1;
}

/* ---- more than codes and ranges ------------------------------------------------------------- */

static uint64_t hash_samples(uint64_t h, const struct dx_tile *tile, const struct dx_used *used)
{
    uint16_t sample[DX_BLOCK_DEXELS];

    if (tile->attr_bytes) {
        for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
            sample[k] = dx_used_has(used, k) ? tile->attr[k] : 0;
        h = dx_hash(h, sample, sizeof(sample));
    }
    if (tile->has_normals) {
        for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++) {
            const uint8_t *normal = (const uint8_t *)tile->normal + 2 * (size_t)k;

            sample[k] = dx_used_has(used, k) ? dx_get_u16(normal) : 0;
        }
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
            bits[m] = dx_used_has(used, k) ? dx_f32_bits(tile->xyz[m]) : 0;
    return dx_hash(h, bits, sizeof(bits));
}

uint64_t dx_tile_hash(const struct dx_tile *tile)
{
    struct digest d = {.rows = dx_rows_get(DX_SIMD_AUTO)};
    struct dx_used used;
    uint64_t h;

    dx_used_mark(&used, tile->code, tile->strut);
    if (dx_used_count(&used) == 0)
        return 0;
    for (uint32_t i = 0; i < DX_BLOCK; i++)
        add_wide(&d, tile->range + (size_t)i * DX_BLOCK, used.row[i]);
    h = hash_samples(end(&d, tile->code, tile->strut, &used), tile, &used);
    if (tile->exact)
        h = hash_points(h, tile, &used);
    return h | 1;
}
