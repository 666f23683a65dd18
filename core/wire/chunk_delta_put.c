/*
 * Encoder of the delta encoding: cell codes in groups of eight, ranges as residuals of the
 * predictor that makes the fewest bits of them. Pure functions.
 */
#include "core/wire/bits.h"
#include "core/wire/chunk_delta.h"
#include "core/wire/chunk_parts.h"

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
        dx_put_bits(b, dx_codes_pack8(x), 3 * n);
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
#define ROOM       (MAX_BLOCKS * DX_DELTA_BLOCK)

/* Ranges and what is known of their neighbours, in rank order; zeros up to a whole block. */
struct series {
    uint32_t n;
    uint32_t range[ROOM], west[ROOM], north[ROOM], north_west[ROOM];
};

static void add_row(struct series *s, const struct dx_tile *tile, const struct dx_used *used,
                    uint32_t row)
{
    for (uint32_t col = 0, k = row * DX_BLOCK; col < DX_BLOCK; col++, k++) {
        const uint32_t *at = tile->range + k;
        const uint8_t *is = used->at + k;
        const bool has_w = col && is[-1], has_n = row && is[-DX_BLOCK];
        const uint32_t m = s->n;

        if (!*is)
            continue;
        s->range[m] = *at;
        if (has_w && has_n && is[-DX_BLOCK - 1]) {
            s->west[m] = at[-1];
            s->north[m] = at[-DX_BLOCK];
            s->north_west[m] = at[-DX_BLOCK - 1];
        } else {
            const uint32_t last = m ? s->range[m - 1] : *at;

            s->west[m] = s->north[m] = s->north_west[m] = has_w   ? at[-1]
                                                          : has_n ? at[-DX_BLOCK]
                                                                  : last;
        }
        s->n++;
    }
}

static void make_series(struct series *s, const struct dx_tile *tile, const struct dx_used *used)
{
    s->n = 0;
    for (uint32_t row = 0; row < DX_BLOCK; row++)
        add_row(s, tile, used, row);
    for (uint32_t m = s->n; m % DX_DELTA_BLOCK; m++) /* residuals of 0 */
        s->range[m] = s->west[m] = s->north[m] = s->north_west[m] = 0;
}

/* Residuals of one predictor. */
struct residuals {
    enum dx_delta_predictor predictor;
    uint32_t n_bits; /* of all blocks, without their widths */
    uint8_t width[MAX_BLOCKS];
    uint32_t folded[ROOM];
};

static uint8_t width_of(uint32_t bits)
{
    return bits ? (uint8_t)(32 - __builtin_clz(bits)) : 0;
}

/* Inlined with each predictor, so that a block is a loop without branches. */
static inline __attribute__((always_inline)) void predict_all(struct residuals *restrict r,
                                                              const struct series *restrict s,
                                                              enum dx_delta_predictor predictor)
{
    r->predictor = predictor;
    r->n_bits = 0;
    for (uint32_t at = 0; at < s->n; at += DX_DELTA_BLOCK) {
        const uint32_t *range = s->range + at, *w = s->west + at, *n = s->north + at;
        const uint32_t *nw = s->north_west + at;
        uint32_t *folded = r->folded + at, all = 0;
        uint32_t left = s->n - at < DX_DELTA_BLOCK ? s->n - at : DX_DELTA_BLOCK;

        for (uint32_t m = 0; m < DX_DELTA_BLOCK; m++) {
            folded[m] = dx_delta_fold(range[m] - dx_delta_predict(predictor, w[m], n[m], nw[m]));
            all |= folded[m];
        }
        r->width[at / DX_DELTA_BLOCK] = width_of(all);
        r->n_bits += width_of(all) * left;
    }
}

static void try_predictor(struct residuals *r, const struct series *s,
                          enum dx_delta_predictor predictor)
{
    switch (predictor) {
    case DX_DELTA_PLANAR:
        predict_all(r, s, DX_DELTA_PLANAR);
        break;
    case DX_DELTA_MEAN:
        predict_all(r, s, DX_DELTA_MEAN);
        break;
    case DX_DELTA_LEFT:
        predict_all(r, s, DX_DELTA_LEFT);
        break;
    default:
        predict_all(r, s, DX_DELTA_MEDIAN);
    }
}

static uint8_t *put_blocks(uint8_t *p, const struct residuals *r, uint32_t n)
{
    struct dx_bit_writer b = {p, 0, 0};
    uint8_t before = 0;

    for (uint32_t at = 0; at < n; at += DX_DELTA_BLOCK) {
        const uint32_t end = n - at < DX_DELTA_BLOCK ? n : at + DX_DELTA_BLOCK;
        const uint8_t width = r->width[at / DX_DELTA_BLOCK];

        dx_put_unary(&b, dx_delta_fold((uint32_t)width - before));
        for (uint32_t m = at; m < end; m++)
            dx_put_bits(&b, r->folded[m], width);
        before = width;
    }
    return dx_end_bits(&b);
}

uint8_t *dx_delta_put_ranges(uint8_t *p, const struct dx_tile *tile, const struct dx_used *used)
{
    struct residuals tried[2], *best = &tried[0], *other = &tried[1];
    struct series s;

    make_series(&s, tile, used);
    try_predictor(best, &s, 0);
    for (enum dx_delta_predictor k = 1; k < DX_N_DELTA_PREDICTORS; k++) {
        try_predictor(other, &s, k);
        if (other->n_bits < best->n_bits) {
            struct residuals *swap = best;

            best = other;
            other = swap;
        }
    }
    *p++ = (uint8_t)best->predictor;
    dx_put_u32(p, s.range[0]);
    return put_blocks(p + 4, best, s.n);
}
