/*
 * The loops of rows.h that decide. Included once by each rows_SET.c, which is compiled for its
 * instruction set and gives the table its name, after its own pack and unpack (rows_generic.c
 * tells what they do). Loops have constant lengths and no branches; each does one kind of
 * arithmetic, so that it becomes vectors of one width.
 */
#include "core/rows/rows.h"

#include <math.h>

#define N       DX_ROWS_N
#define CELLS   DX_ROWS_CELLS
#define CORNERS DX_ROWS_CORNERS

/* ---- the first-order rule ------------------------------------------------------------------- */

static dx_bits valid_row(const uint16_t *range)
{
    uint16_t valid[N];

    for (uint32_t q = 0; q < N; q++)
        valid[q] = range[q] != 0 ? UINT16_MAX : 0;
    return pack16(valid);
}

static void valid_rows(struct dx_row_words *valid, const uint16_t *const *range,
                       struct dx_row_run run, dx_bits columns)
{
    for (uint32_t p = run.first; p < run.end; p++)
        dx_words_put(valid, p, valid_row(range[p]) & columns);
}

static dx_bits valid_wide_row(const uint32_t *range)
{
    uint32_t valid[N];

    for (uint32_t q = 0; q < N; q++)
        valid[q] = range[q] != 0 ? UINT32_MAX : 0;
    return pack32(valid, N);
}

static inline uint16_t mul_high(uint16_t x, uint16_t y)
{
    return (uint16_t)((uint32_t)x * y >> 16);
}

static inline uint16_t min16(uint16_t x, uint16_t y)
{
    return x < y ? x : y;
}

static inline uint16_t max16(uint16_t x, uint16_t y)
{
    return x > y ? x : y;
}

/* Each product its own loop: together they become 32-bit ones at four times the instructions. */
static void noise_row(uint16_t *restrict out, const uint16_t *range, uint16_t t0, uint16_t n2)
{
    uint16_t square[N];

    for (uint32_t q = 0; q < N; q++)
        square[q] = mul_high(range[q], range[q]);
    for (uint32_t q = 0; q < N; q++)
        out[q] = (uint16_t)(t0 + mul_high(square[q], n2));
}

/*
 * hi - lo <= noise + (lo c >> 16) in 16 bits: the sum might not fit, so what the noise term leaves
 * of the difference is compared with the tilt term. The noise term does not fall with range, so the
 * nearer sample has the smaller one.
 */
static inline __attribute__((always_inline)) dx_bits join_edges(const uint16_t *x,
                                                                const uint16_t *y,
                                                                const uint16_t *noise_x,
                                                                const uint16_t *noise_y,
                                                                const uint16_t *c, uint32_t step)
{
    uint16_t near[N];

    for (uint32_t q = 0; q < N; q++) {
        uint16_t lo = min16(x[q], y[q]), difference = (uint16_t)(max16(x[q], y[q]) - lo);
        uint16_t noise = min16(noise_x[q], noise_y[q]), tilt = mul_high(lo, c[q * step]);
        uint16_t rest = (uint16_t)(max16(difference, noise) - noise);

        near[q] = rest <= tilt ? UINT16_MAX : 0;
    }
    return pack16(near);
}

/* Ranges of the upper and the lower corners of a row of cells, and their noise terms. */
struct corners {
    const uint16_t *top, *bottom, *noise_top, *noise_bottom;
};

static inline __attribute__((always_inline)) void join_row(struct dx_row_words joined[DX_ROW_EDGES],
                                                           uint32_t p, const struct corners *rows,
                                                           const uint16_t *const c[DX_ROW_EDGES],
                                                           uint32_t step)
{
    const uint16_t *a = rows->top, *d = rows->bottom;
    const uint16_t *noise_a = rows->noise_top, *noise_d = rows->noise_bottom;

    dx_words_put(&joined[0], p, join_edges(a, a + 1, noise_a, noise_a + 1, c[0], step));
    dx_words_put(&joined[1], p, join_edges(a, d, noise_a, noise_d, c[1], step));
    dx_words_put(&joined[2], p, join_edges(a, d + 1, noise_a, noise_d + 1, c[2], step));
    dx_words_put(&joined[3], p, join_edges(a + 1, d, noise_a + 1, noise_d, c[3], step));
}

/* Noise terms are made a row before they are read: a load across two stores waits until they are
 * done. */
static void join_rows(struct dx_row_words joined[DX_ROW_EDGES],
                      const struct dx_row_first_order *rows)
{
    uint16_t noise[4][N + 8] = {{0}}; /* by row & 3 */
    const struct dx_row_run run = rows->run;

    noise_row(noise[run.first & 3], rows->range[run.first], rows->t0, rows->n2);
    noise_row(noise[(run.first + 1) & 3], rows->range[run.first + 1], rows->t0, rows->n2);
    for (uint32_t p = run.first; p < run.end; p++) {
        const struct corners at = {rows->range[p], rows->range[p + 1], noise[p & 3],
                                   noise[(p + 1) & 3]};

        if (p + 2 < run.end)
            noise_row(noise[(p + 2) & 3], rows->range[p + 2], rows->t0, rows->n2);
        if (rows->each) {
            join_row(joined, p, &at, rows->each[p], 1);
        } else {
            const uint16_t *c = rows->c[p], *const of_row[DX_ROW_EDGES] = {c, c + 1, c + 2, c + 3};

            join_row(joined, p, &at, of_row, 0);
        }
    }
}

/*
 * hi - lo <= t0 + (lo c >> 16) + ((lo lo >> 16) n2 >> 16) in f64. Rounding is below 8 * 2^-53 of
 * the sum; the integers cut two products, and the square before it is multiplied.
 */
static inline __attribute__((always_inline)) struct dx_row_joined join_wide_edges(
    const uint32_t *x, const uint32_t *y, double t0, double noise, const uint32_t *c, uint32_t step)
{
    const double n2 = noise * 0x1p-32, cut = 3 + 1.001 * 0x1p-16 * noise;
    uint32_t near[N], unsure[N];

    for (uint32_t q = 0; q < N; q++) {
        uint32_t lo = x[q] < y[q] ? x[q] : y[q], hi = x[q] < y[q] ? y[q] : x[q];
        double r = (double)lo, apart = (double)(hi - lo);
        double gate = t0 + r * ((double)c[q * step] * 0x1p-16) + r * r * n2;
        double margin = 0x1p-50 * gate + cut;

        near[q] = apart <= gate - margin ? UINT32_MAX : 0;
        unsure[q] = apart <= gate - margin || apart > gate + margin ? 0 : UINT32_MAX;
    }
    return (struct dx_row_joined){pack32(near, N), pack32(unsure, N)};
}

static inline __attribute__((always_inline)) void join_wide_rows(
    struct dx_row_joined out[DX_ROW_EDGES], const struct dx_row_wide_pair *rows,
    const uint32_t *const c[DX_ROW_EDGES], uint32_t step)
{
    const uint32_t *a = rows->top, *d = rows->bottom;

    out[0] = join_wide_edges(a, a + 1, rows->t0, rows->n2, c[0], step);
    out[1] = join_wide_edges(a, d, rows->t0, rows->n2, c[1], step);
    out[2] = join_wide_edges(a, d + 1, rows->t0, rows->n2, c[2], step);
    out[3] = join_wide_edges(a + 1, d, rows->t0, rows->n2, c[3], step);
}

static void join_wide_row(struct dx_row_joined out[DX_ROW_EDGES],
                          const struct dx_row_wide_pair *rows, const uint32_t c[DX_ROW_EDGES])
{
    const uint32_t *const each[DX_ROW_EDGES] = {c, c + 1, c + 2, c + 3};

    join_wide_rows(out, rows, each, 0);
}

static void join_wide_each_row(struct dx_row_joined out[DX_ROW_EDGES],
                               const struct dx_row_wide_pair *rows,
                               const uint32_t *const c[DX_ROW_EDGES])
{
    join_wide_rows(out, rows, c, 1);
}
