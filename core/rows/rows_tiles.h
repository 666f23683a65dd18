/*
 * The loops of rows.h over tiles that are the same C for every instruction set: ranks, the hash,
 * and where the dexels of a block row are. Included by rows_eights.h and rows_compress.h.
 */
#include "core/rows/rows.h"

#include <string.h>

static void count_rows(uint16_t *restrict first, const dx_bits *row, uint32_t n_rows)
{
    uint32_t n = 0;

    for (uint32_t i = 0; i < n_rows; i++) {
        first[i] = (uint16_t)n;
        n += dx_bits_count(row[i]);
    }
    first[n_rows] = (uint16_t)n;
}

/* What one row writes too much the next one mends. */
static void widen_rows(uint32_t *restrict out, const uint16_t *from, uint32_t width,
                       uint32_t n_rows)
{
    for (uint32_t i = 0; i < n_rows; i++, out += DX_ROWS_BLOCK, from += width)
        for (uint32_t j = 0; j < DX_ROWS_N; j++)
            out[j] = from[j];
}

/* ---- the hash ------------------------------------------------------------------------------- */

/* Each word of a row has a lane of its own, so that lanes become vectors. Odd multipliers. */
static inline void mix(uint64_t lane[restrict DX_ROWS_LANES],
                       const uint64_t word[restrict DX_ROWS_LANES])
{
    for (uint32_t k = 0; k < DX_ROWS_LANES; k++) {
        const uint64_t x = (lane[k] ^ word[k]) * (0x9e3779b185ebca87u + 2 * k);

        lane[k] = x ^ x >> 29;
    }
}

/* Rows take turns among four sums: one alone would wait for the product of the row before. */
static void digest_rows(uint64_t lane[DX_ROWS_LANES], const uint16_t *const *range,
                        const dx_bits *used, uint32_t n_rows)
{
    uint64_t sum[4][DX_ROWS_LANES] = {{0}}, word[DX_ROWS_LANES] = {0};
    uint16_t kept[DX_ROWS_N];

    for (uint32_t i = 0; i < n_rows; i++) {
        keep_used16(kept, range[i], used[i]);
        memcpy(word, kept, sizeof(kept));
        mix(sum[i & 3], word);
    }
    for (uint32_t k = 0; k < 4; k++)
        mix(lane, sum[k]);
}

static void digest_words_rows(uint64_t lane[DX_ROWS_LANES], const uint64_t (*word)[DX_ROWS_LANES],
                              uint32_t n_rows)
{
    for (uint32_t i = 0; i < n_rows; i++)
        mix(lane, word[i]);
}

/* ---- points --------------------------------------------------------------------------------- */

/* The operations are those of dx_geometry_point. */
static inline void spin_points(float *restrict x, float *restrict y, float *restrict z,
                               const struct dx_row_spin *spin, const uint32_t *range)
{
    const float *d = spin->row, unit_m = spin->unit_m;

    for (uint32_t j = 0; j < DX_ROWS_N; j++) {
        float r = (float)range[j] * unit_m;
        float u = d[3] + r * d[0], v = d[4] + r * d[1];

        x[j] = u * spin->c[j] - v * spin->s[j];
        y[j] = u * spin->s[j] + v * spin->c[j];
        z[j] = d[5] + r * d[2];
    }
}
