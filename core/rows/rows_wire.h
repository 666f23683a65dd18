/*
 * The loops of rows.h for the encodings of chunks: codes in three bits each, and what the delta
 * encoding's predictors leave of a block row. Included once by each rows_SET.c.
 */
#include "core/base/bytes.h"
#include "core/base/codes.h"
#include "core/base/delta.h"
#include "core/rows/rows.h"

/* ---- codes ---------------------------------------------------------------------------------- */

#define CODE_WORDS (DX_ROWS_CELLS / 8)

/* Each store mends what the one before wrote too much. */
static void pack_codes_rows(uint8_t *restrict out, const uint8_t *code, uint32_t n_rows)
{
    uint64_t word[CODE_WORDS * DX_ROWS_CELLS];
    const uint32_t n = CODE_WORDS * n_rows;

    for (uint32_t k = 0; k < n; k++)
        word[k] = dx_codes_pack8(dx_get_u64(code + 8 * (size_t)k));
    for (uint32_t k = 0; k < n; k++)
        dx_put_u32(out + 3 * (size_t)k, (uint32_t)word[k]);
}

/* A byte of the sum is up to 128. */
static uint32_t count_triangles_rows(const uint8_t *code, uint32_t n_rows)
{
    uint64_t sum[CODE_WORDS] = {0};
    uint32_t n = 0;

    for (uint32_t i = 0; i < n_rows; i++, code += DX_ROWS_CELLS)
        for (uint32_t k = 0; k < CODE_WORDS; k++)
            sum[k] += dx_codes_triangles8(dx_get_u64(code + 8 * k));
    for (uint32_t k = 0; k < DX_ROWS_CELLS; k++)
        n += (uint8_t)(sum[k / 8] >> 8 * (k % 8));
    return n;
}

/* ---- delta ---------------------------------------------------------------------------------- */

/* What is known of each dexel's neighbours. Where they are not all used, one stands for the three:
 * W, else N, else what the caller knows. */
struct neighbours {
    uint32_t west[DX_ROWS_N], north[DX_ROWS_N], north_west[DX_ROWS_N];
};

static inline void find_neighbours(struct neighbours *restrict out, uint8_t *restrict alone,
                                   const struct dx_row_delta *row)
{
    const uint32_t *range = row->range, *north = row->north;
    const uint8_t *used = row->used, *above = row->used_north;
    uint32_t all[DX_ROWS_N], west[DX_ROWS_N];

    out->west[0] = out->north[0] = out->north_west[0] = north[0];
    alone[0] = used[0] & (above[0] ^ 1);
    for (uint32_t j = 1; j < DX_ROWS_N; j++)
        alone[j] = used[j] & ((used[j - 1] | above[j]) ^ 1);
    for (uint32_t j = 1; j < DX_ROWS_N; j++)
        west[j] = used[j - 1];
    for (uint32_t j = 1; j < DX_ROWS_N; j++)
        all[j] = used[j - 1] & above[j] & above[j - 1];
    for (uint32_t j = 1; j < DX_ROWS_N; j++) {
        uint32_t w = range[j - 1], n = north[j], nw = north[j - 1];
        uint32_t one = west[j] ? w : n;

        out->west[j] = all[j] ? w : one;
        out->north[j] = all[j] ? n : one;
        out->north_west[j] = all[j] ? nw : one;
    }
}

static inline __attribute__((always_inline)) void predict_row(uint32_t *restrict folded,
                                                              const uint32_t *range,
                                                              const struct neighbours *at,
                                                              enum dx_delta_predictor predictor)
{
    for (uint32_t j = 0; j < DX_ROWS_N; j++)
        folded[j] = dx_delta_fold(
            range[j] - dx_delta_predict(predictor, at->west[j], at->north[j], at->north_west[j]));
}

static void deltas_row(uint32_t folded[DX_N_DELTA_PREDICTORS][DX_ROWS_N], uint8_t *restrict alone,
                       const struct dx_row_delta *row)
{
    struct neighbours at;

    find_neighbours(&at, alone, row);
    predict_row(folded[DX_DELTA_PLANAR], row->range, &at, DX_DELTA_PLANAR);
    predict_row(folded[DX_DELTA_MEAN], row->range, &at, DX_DELTA_MEAN);
    predict_row(folded[DX_DELTA_LEFT], row->range, &at, DX_DELTA_LEFT);
    predict_row(folded[DX_DELTA_MEDIAN], row->range, &at, DX_DELTA_MEDIAN);
}
