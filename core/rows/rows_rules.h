/*
 * The loops of rows.h that decide. Included once by each rows_SET.c, which is compiled for its
 * instruction set and gives the table its name. Loops have constant lengths and no branches; each
 * does one kind of arithmetic, so that it becomes vectors of one width.
 */
#include "core/rows/rows.h"

#include <math.h>

#define N       DX_ROWS_N
#define CELLS   DX_ROWS_CELLS
#define CORNERS DX_ROWS_CORNERS

/* ---- the first-order rule ------------------------------------------------------------------- */

static void valid_row(uint8_t *restrict out, const uint16_t *range)
{
    for (uint32_t q = 0; q < N; q++)
        out[q] = range[q] != 0;
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
static inline __attribute__((always_inline)) bool join_rows(uint8_t *restrict joined,
                                                            uint8_t *restrict failed,
                                                            const struct dx_row_pair *pair,
                                                            const uint16_t *c, uint32_t step)
{
    const uint16_t *x = pair->x, *y = pair->y, *noise_x = pair->noise_x, *noise_y = pair->noise_y;
    uint16_t near[N], there[N], any = 0;

    for (uint32_t q = 0; q < N; q++) {
        uint16_t lo = min16(x[q], y[q]), difference = (uint16_t)(max16(x[q], y[q]) - lo);
        uint16_t noise = min16(noise_x[q], noise_y[q]), tilt = mul_high(lo, c[q * step]);
        uint16_t rest = (uint16_t)(max16(difference, noise) - noise);

        near[q] = rest <= tilt;
        there[q] = lo != 0;
        any |= there[q] & (near[q] ^ 1);
    }
    for (uint32_t q = 0; q < N; q++)
        joined[q] = (uint8_t)(near[q] & there[q]);
    for (uint32_t q = 0; q < N; q++)
        failed[q] = (uint8_t)(there[q] & (near[q] ^ 1));
    return any;
}

static bool join_row(uint8_t *restrict joined, uint8_t *restrict failed,
                     const struct dx_row_pair *pair, uint16_t c)
{
    return join_rows(joined, failed, pair, &c, 0);
}

static bool join_each_row(uint8_t *restrict joined, uint8_t *restrict failed,
                          const struct dx_row_pair *pair, const uint16_t *c)
{
    return join_rows(joined, failed, pair, c, 1);
}

/*
 * hi - lo <= t0 + (lo c >> 16) + ((lo lo >> 16) n2 >> 16) in f64. Rounding is below 8 * 2^-53 of
 * the sum; the integers cut two products, and the square before it is multiplied.
 */
static inline __attribute__((always_inline)) struct dx_row_joined join_wide_rows(
    uint8_t *restrict joined, uint8_t *restrict failed, uint8_t *restrict unsure,
    const struct dx_row_wide_pair *pair, const uint32_t *c, uint32_t step)
{
    const uint32_t *x = pair->x, *y = pair->y;
    const double t0 = pair->t0, n2 = pair->n2 * 0x1p-32, cut = 3 + 1.001 * 0x1p-16 * pair->n2;
    uint8_t any_failed = 0, any_unsure = 0;
    uint32_t near[N], far[N], there[N];

    for (uint32_t q = 0; q < N; q++) {
        uint32_t lo = x[q] < y[q] ? x[q] : y[q], hi = x[q] < y[q] ? y[q] : x[q];
        double r = (double)lo, apart = (double)(hi - lo);
        double gate = t0 + r * ((double)c[q * step] * 0x1p-16) + r * r * n2;
        double margin = 0x1p-50 * gate + cut;

        near[q] = apart <= gate - margin;
        far[q] = apart > gate + margin;
        there[q] = lo != 0;
    }
    for (uint32_t q = 0; q < N; q++) {
        joined[q] = (uint8_t)(near[q] & there[q]);
        failed[q] = (uint8_t)(far[q] & there[q]);
        unsure[q] = (uint8_t)(there[q] & ((near[q] | far[q]) ^ 1));
        any_failed |= failed[q];
        any_unsure |= unsure[q];
    }
    return (struct dx_row_joined){any_failed, any_unsure};
}

static struct dx_row_joined join_wide_row(uint8_t *restrict joined, uint8_t *restrict failed,
                                          uint8_t *restrict unsure,
                                          const struct dx_row_wide_pair *pair, uint32_t c)
{
    return join_wide_rows(joined, failed, unsure, pair, &c, 0);
}

static struct dx_row_joined join_wide_each_row(uint8_t *restrict joined, uint8_t *restrict failed,
                                               uint8_t *restrict unsure,
                                               const struct dx_row_wide_pair *pair,
                                               const uint32_t *c)
{
    return join_wide_rows(joined, failed, unsure, pair, c, 1);
}

/* ---- mixed pixels --------------------------------------------------------------------------- */

static inline __attribute__((always_inline)) void vote_columns(uint8_t *restrict alive,
                                                               const uint8_t *h, const uint8_t *v,
                                                               const uint8_t *v_above,
                                                               const uint8_t *const valid[3],
                                                               uint32_t first, uint32_t end)
{
    const uint8_t *above = valid[0], *here = valid[1], *below = valid[2];

    for (uint32_t q = first; q < end; q++) {
        uint8_t row = (uint8_t)(here[q] & here[q + 2] & ((h[q] | h[q + 1]) ^ 1));
        uint8_t column = (uint8_t)(above[q + 1] & below[q + 1] & ((v_above[q + 1] | v[q + 1]) ^ 1));

        alive[q + 1] = (uint8_t)(here[q + 1] & ((row | column) ^ 1));
    }
}

/* In two, so that the longest vectors leave no rest. */
static void vote_row(uint8_t *restrict alive, const uint8_t *h, const uint8_t *v,
                     const uint8_t *v_above, const uint8_t *const valid[3])
{
    vote_columns(alive, h, v, v_above, valid, 0, 64);
    vote_columns(alive, h, v, v_above, valid, 64, N);
}

/* ---- missing dexels ------------------------------------------------------------------------- */

static inline __attribute__((always_inline)) void missing_columns(
    struct dx_row_missing *restrict out, const uint8_t *const valid[3], uint8_t two, uint32_t first,
    uint32_t end)
{
    const uint8_t *above = valid[0], *here = valid[1], *below = valid[2];
    uint8_t any_lone = 0, any_crowded = 0;

    for (uint32_t q = first; q < end; q++) {
        uint8_t n = above[q + 1], s = below[q + 1], w = here[q], e = here[q + 2];
        uint8_t missing = here[q + 1] ^ 1, lone = missing & n & s & w & e;
        uint8_t ends = (n & s) | (w & e) | (two & (n | s | w | e));

        out->lone[q + 1] = lone;
        out->crowded[q + 1] = missing & ends & (lone ^ 1);
        any_lone |= lone;
        any_crowded |= out->crowded[q + 1];
    }
    out->has_lone |= any_lone;
    out->has_crowded |= any_crowded;
}

/* In two, so that the longest vectors leave no rest. */
static void missing_row(struct dx_row_missing *restrict out, const uint8_t *const valid[3],
                        uint8_t two)
{
    out->has_lone = out->has_crowded = 0;
    missing_columns(out, valid, two, 0, 64);
    missing_columns(out, valid, two, 64, N);
}

/* ---- cells ---------------------------------------------------------------------------------- */

static void code_row(uint8_t *restrict code, uint8_t *restrict even,
                     const struct dx_row_edges *edges, const uint8_t *prefer_bd)
{
    const uint8_t *top = edges->alive, *bottom = edges->alive_below;

    for (uint32_t j = 0; j < CELLS; j++) {
        uint8_t a = top[j], b = top[j + 1], c = bottom[j + 1], d = bottom[j];
        uint8_t ab = edges->h[j] & a & b, dc = edges->h_below[j] & d & c;
        uint8_t ad = edges->v[j] & a & d, bc = edges->v[j + 1] & b & c;
        uint8_t ac = edges->ac[j] & a & c, bd = edges->bd[j] & b & d;
        uint8_t abc = ab & bc & ac, acd = dc & ad & ac;
        uint8_t abd = ab & ad & bd, bcd = bc & dc & bd;
        uint8_t n_ac = (uint8_t)(abc + acd), n_bd = (uint8_t)(abd + bcd);
        uint8_t on_bd = (uint8_t)(n_bd > n_ac) | ((n_bd == n_ac) & prefer_bd[j]);

        /* enum dx_cell: 0..3 on a-c; 4..6 on b-d, where none is none */
        code[j] = on_bd ? (uint8_t)(abd + 2 * bcd + (n_bd ? 3 : 0)) : (uint8_t)(abc + 2 * acd);
        even[j] = (n_bd == n_ac) & (n_ac != 0);
    }
}
