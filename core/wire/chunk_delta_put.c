/*
 * Encoder of the delta encoding: cell codes in groups of eight, ranges as residuals of the
 * predictor that makes the fewest bits of them. Pure functions.
 */
#include "core/base/codes.h"
#include "core/base/delta.h"
#include "core/rows/rows.h"
#include "core/wire/bits.h"
#include "core/wire/chunk_parts.h"

#include <string.h>

/* ---- cell codes ----------------------------------------------------------------------------- */

#define ONES 0x0101010101010101u

/* The lowest bit of each of eight bytes. */
static uint32_t low_bits8(uint64_t x)
{
    return (uint32_t)((x & ONES) * 0x0102040810204080u >> 56);
}

/* A group of n codes, one a byte; bytes beyond are 0. */
static void put_group(struct dx_bit_writer *b, uint64_t x, unsigned n)
{
    const uint64_t full = n < 8 ? (UINT64_C(1) << 8 * n) - 1 : UINT64_MAX;
    const uint64_t other = x ^ (full & DX_CELL_ABC_ACD * ONES); /* 5 where abd + bcd */

    if (other == 0) {
        dx_put_bits(b, 0, 1);
    } else if ((other & ~(5 * ONES)) == 0 && ((other ^ other >> 2) & ONES) == 0) {
        dx_put_bits(b, 1, 2);
        dx_put_bits(b, low_bits8(other), n);
    } else if (x == 0) {
        dx_put_bits(b, 3, 3);
    } else {
        dx_put_bits(b, 7, 3);
        dx_put_bits(b, (uint32_t)dx_codes_pack8(x), 3 * n);
    }
}

uint8_t *dx_delta_put_codes(uint8_t *p, const struct dx_tile *tile)
{
    struct dx_bit_writer b = {p, 0, 0};

    for (uint32_t i = 0; i < tile->cell_rows; i++)
        for (uint32_t j = 0; j < tile->cell_cols; j += 8) {
            const uint32_t left = tile->cell_cols - j;

            /* codes beyond cell_cols are 0, and the stride is a multiple of eight */
            put_group(&b, dx_get_u64(tile->code + DX_TILE_CELLS * i + j), left < 8 ? left : 8);
        }
    return dx_end_bits(&b);
}

/* ---- ranges --------------------------------------------------------------------------------- */

#define MAX_BLOCKS ((DX_TILE_MAX_VERTICES + DX_DELTA_BLOCK - 1) / DX_DELTA_BLOCK)
#define ROOM       (MAX_BLOCKS * DX_DELTA_BLOCK + DX_ROWS_SLACK)

/* Folded residuals of the used dexels by each predictor, in rank order; zeros up to a whole block.
 */
struct residuals {
    uint32_t n, first; /* the first range */
    uint32_t folded[DX_N_DELTA_PREDICTORS][ROOM];
};

/* Where the one used dexel before column `col` of a row is; `last` when there is none in it. */
static uint32_t range_before(const struct dx_row_delta *row, uint32_t col, uint32_t last)
{
    while (col > 0)
        if (row->used[--col])
            return row->range[col];
    return last;
}

/* Without a neighbour: the range that is coded before. */
static void mend_alone(uint32_t folded[DX_N_DELTA_PREDICTORS][DX_ROWS_N], const uint8_t *alone,
                       const struct dx_row_delta *row, uint32_t last)
{
    for (uint32_t col = 0; col < DX_BLOCK; col++)
        for (int k = 0; alone[col] && k < DX_N_DELTA_PREDICTORS; k++)
            folded[k][col] = dx_delta_fold(row->range[col] - range_before(row, col, last));
}

static void add_row(struct residuals *r, const struct dx_rows *rows, const struct dx_row_delta *row,
                    dx_bits used, uint32_t last)
{
    uint32_t folded[DX_N_DELTA_PREDICTORS][DX_ROWS_N], n = 0;
    uint8_t alone[DX_ROWS_N];

    rows->deltas(folded, alone, row);
    if (memchr(alone, 1, DX_BLOCK))
        mend_alone(folded, alone, row, last);
    for (int k = 0; k < DX_N_DELTA_PREDICTORS; k++)
        n = (uint32_t)(rows->keep(r->folded[k] + r->n, folded[k], used) - r->folded[k]);
    r->n = n;
}

/* One byte of 0 or 1 a column. */
static void spread(uint8_t out[DX_ROWS_N], dx_bits used)
{
    for (uint32_t j = 0; j < DX_ROWS_N; j += 8)
        dx_put_u64(out + j, dx_bits_spread8((uint64_t)(used >> j)));
}

static void find_residuals(struct residuals *r, const struct dx_tile *tile,
                           const struct dx_used *used)
{
    const struct dx_rows *rows = dx_rows_get(DX_SIMD_AUTO);
    uint8_t is[2][DX_ROWS_N] = {{0}, {0}}; /* of rows, by row & 1 */
    uint32_t last = 0;

    r->n = 0;
    for (uint32_t row = 0; row < DX_BLOCK; row++) {
        const uint32_t at = row * DX_BLOCK, north = row ? at - DX_BLOCK : at;
        const struct dx_row_delta d = {tile->range + at, tile->range + north, is[row & 1],
                                       is[~row & 1]};

        spread(is[row & 1], used->row[row]);
        if (!used->row[row])
            continue;
        if (r->n == 0)
            last = r->first = tile->range[at + dx_bits_first(used->row[row])];
        add_row(r, rows, &d, used->row[row], last);
        last = range_before(&d, DX_BLOCK, last);
    }
    for (int k = 0; k < DX_N_DELTA_PREDICTORS; k++)
        memset(r->folded[k] + r->n, 0, DX_DELTA_BLOCK * sizeof(r->folded[k][0]));
}

/* ---- blocks --------------------------------------------------------------------------------- */

static uint8_t width_of(uint32_t bits)
{
    return bits ? (uint8_t)(32 - __builtin_clz(bits)) : 0;
}

/* Widths of the blocks; returns the bits of all of them, without the widths'. */
static uint32_t find_widths(uint8_t width[MAX_BLOCKS], const uint32_t *folded, uint32_t n)
{
    uint32_t n_bits = 0;

    for (uint32_t at = 0; at < n; at += DX_DELTA_BLOCK) {
        const uint32_t *block = folded + at;
        uint32_t all = 0, left = n - at < DX_DELTA_BLOCK ? n - at : DX_DELTA_BLOCK;

        for (uint32_t m = 0; m < DX_DELTA_BLOCK; m++)
            all |= block[m];
        width[at / DX_DELTA_BLOCK] = width_of(all);
        n_bits += width_of(all) * left;
    }
    return n_bits;
}

/* Words of twice the width. */
static inline void join_pairs(uint64_t *restrict out, const uint64_t *restrict in, uint32_t n,
                              unsigned width)
{
    for (uint32_t m = 0; m < n / 2; m++)
        out[m] = in[2 * m] | in[2 * m + 1] << width;
}

static void put_words(struct dx_bit_writer *b, const uint64_t *word, uint32_t n, unsigned width)
{
    for (uint32_t m = 0; m < n; m++)
        dx_put_long_bits(b, word[m], width);
}

/* A whole block's residuals: first as many side by side as a word holds, since each that is put
 * waits for the one before. */
static void put_block(struct dx_bit_writer *b, const uint32_t block[DX_DELTA_BLOCK], unsigned w)
{
    uint64_t one[DX_DELTA_BLOCK], two[DX_DELTA_BLOCK / 2], four[DX_DELTA_BLOCK / 4];

    for (uint32_t m = 0; m < DX_DELTA_BLOCK; m++)
        one[m] = block[m];
    join_pairs(two, one, DX_DELTA_BLOCK, w);
    if (w > 16) {
        put_words(b, two, DX_DELTA_BLOCK / 2, 2 * w);
        return;
    }
    join_pairs(four, two, DX_DELTA_BLOCK / 2, 2 * w);
    if (w > 8) {
        put_words(b, four, DX_DELTA_BLOCK / 4, 4 * w);
        return;
    }
    join_pairs(one, four, DX_DELTA_BLOCK / 4, 4 * w);
    put_words(b, one, DX_DELTA_BLOCK / 8, 8 * w);
}

static uint8_t *put_blocks(uint8_t *p, const uint32_t *folded, const uint8_t width[MAX_BLOCKS],
                           uint32_t n)
{
    struct dx_bit_writer b = {p, 0, 0};
    uint8_t before = 0;

    for (uint32_t at = 0; at < n; at += DX_DELTA_BLOCK) {
        const uint32_t *block = folded + at;
        const uint32_t left = n - at < DX_DELTA_BLOCK ? n - at : DX_DELTA_BLOCK;
        const uint8_t w = width[at / DX_DELTA_BLOCK];

        dx_put_unary(&b, dx_delta_fold((uint32_t)w - before));
        if (left == DX_DELTA_BLOCK)
            put_block(&b, block, w);
        for (uint32_t m = 0; left < DX_DELTA_BLOCK && m < left; m++)
            dx_put_bits(&b, block[m], w);
        before = w;
    }
    return dx_end_bits(&b);
}

uint8_t *dx_delta_put_ranges(uint8_t *p, const struct dx_tile *tile, const struct dx_used *used)
{
    uint8_t width[DX_N_DELTA_PREDICTORS][MAX_BLOCKS];
    uint32_t least = UINT32_MAX;
    struct residuals r;
    int best = 0;

    find_residuals(&r, tile, used);
    for (int k = 0; k < DX_N_DELTA_PREDICTORS; k++) {
        const uint32_t n_bits = find_widths(width[k], r.folded[k], r.n);

        if (n_bits < least) {
            least = n_bits;
            best = k;
        }
    }
    *p++ = (uint8_t)best;
    dx_put_u32(p, r.first);
    return put_blocks(p + 4, r.folded[best], width[best], r.n);
}
