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

/* ---- bends ---------------------------------------------------------------------------------- */

/*
 * Rounding: an f32 is off by 2^-24 of itself. An inverse range takes one rounding, a residual three
 * products and two differences more, a bend one sum, the bias seven operations: all that together
 * is below 16 of them. The integers are cut to whole numbers: eight inverse ranges with weights of
 * at most 1 and the noise, below 16 units.
 */
#define ROUNDING 0x1p-20f
#define CUTS     16.0f
#define TOO_NEAR 0x1p60f

static void inverse_row(float *restrict out, const uint16_t *range)
{
    float r[N];

    for (uint32_t q = 0; q < N; q++)
        r[q] = (float)range[q];
    for (uint32_t q = 0; q < N; q++) {
        float inverse = r[q] < 16 ? TOO_NEAR : 0x1p40f / r[q];

        out[q] = r[q] > 0 ? inverse : 0;
    }
}

static inline __attribute__((always_inline)) void residual_at(struct dx_row_residuals *restrict out,
                                                              const float *const inverse[3],
                                                              uint32_t j,
                                                              const struct dx_row_weights *w)
{
    const float *above = inverse[0], *here = inverse[1] + 1, *below = inverse[2];
    float ac = above[j] * w->ac[0] + below[j + 2] * w->ac[1];
    float bd = above[j + 2] * w->bd[0] + below[j] * w->bd[1];

    out->ac[j] = here[j] - ac;
    out->bd[j] = here[j] - bd;
    out->size[j] = here[j] + ac + bd;
}

static void residuals_row(struct dx_row_residuals *restrict out, const float *const inverse[3],
                          const struct dx_row_weights *w)
{
    const struct dx_row_weights of_row = *w;

    for (uint32_t j = 0; j < CORNERS; j++)
        residual_at(out, inverse, j, &of_row);
}

static void residuals_each_row(struct dx_row_residuals *restrict out, const float *const inverse[3],
                               const struct dx_row_weights *w)
{
    for (uint32_t j = 0; j < CORNERS; j++)
        residual_at(out, inverse, j, &w[j]);
}

static inline float min32(float x, float y)
{
    return x < y ? x : y;
}

static inline float sigma_of(const struct dx_row_sigma *s, float r)
{
    return min32(s->max, s->a0 + r * (s->a1 + r * s->a2));
}

/* What one diagonal bends more than the other, less the bias: positive for b-d. `margin` is how far
 * it can be from what integers say. 2^-47: the noise of q is sigma8 q / r, with q / r = q^2 / 2^40,
 * in 1/256, doubled. */
static inline void compare_bends(float *restrict more, float *restrict margin,
                                 const struct dx_row_bend *row, const struct dx_row_sigma *sigma)
{
    const struct dx_row_residuals *top = row->top, *bottom = row->bottom;
    const struct dx_row_sigma s = *sigma;

    for (uint32_t j = 0; j < CELLS; j++) {
        float ac = fabsf(top->ac[j] + bottom->ac[j + 1]);
        float bd = fabsf(top->bd[j + 1] + bottom->bd[j]);
        float size = top->size[j] + top->size[j + 1] + bottom->size[j] + bottom->size[j + 1];
        float slope = row->inverse[j] * row->inverse[j] * 0x1p-47f;
        float bias = sigma_of(&s, (float)row->range[j]) * slope;

        more[j] = ac - bd - bias;
        margin[j] = ROUNDING * (size + bias) + s.off * slope + CUTS;
    }
}

/* The same of the ranges of the corners; 4 sqrt2 sigma. */
static inline void compare_corners(float *restrict more, float *restrict margin,
                                   const struct dx_row_bend *row, const struct dx_row_sigma *sigma)
{
    const uint16_t *top = row->range, *bottom = row->range_below;
    const struct dx_row_sigma s = *sigma;
    const float scale = 1448 / 65536.0f;
    uint16_t nearest[CELLS], ac[CELLS], bd[CELLS];

    for (uint32_t j = 0; j < CELLS; j++) {
        uint16_t a = top[j], b = top[j + 1], c = bottom[j + 1], d = bottom[j];

        nearest[j] = min16(min16(a, c), min16(b, d));
        ac[j] = (uint16_t)(max16(a, c) - min16(a, c));
        bd[j] = (uint16_t)(max16(b, d) - min16(b, d));
    }
    for (uint32_t j = 0; j < CELLS; j++) {
        float bias = sigma_of(&s, (float)nearest[j]) * scale;

        more[j] = (float)ac[j] - (float)bd[j] - bias;
        margin[j] = ROUNDING * bias + s.off * scale;
    }
}

static inline void choose_lanes(float *restrict out, const float *x, const float *y,
                                const uint8_t *first)
{
    for (uint32_t j = 0; j < CELLS; j++) {
        float a = x[j], b = y[j];

        out[j] = first[j] ? a : b;
    }
}

static inline void tell(uint8_t *restrict prefer_bd, uint8_t *restrict unsure, const float *more,
                        const float *margin)
{
    uint16_t prefers[CELLS], sure[CELLS];

    for (uint32_t j = 0; j < CELLS; j++)
        prefers[j] = more[j] > 0;
    for (uint32_t j = 0; j < CELLS; j++)
        sure[j] = fabsf(more[j]) > margin[j]; /* not where it is no number */
    for (uint32_t j = 0; j < CELLS; j++) {
        prefer_bd[j] = (uint8_t)prefers[j];
        unsure[j] = (uint8_t)(sure[j] ^ 1);
    }
}

static void bend_row(uint8_t *restrict prefer_bd, uint8_t *restrict unsure,
                     const struct dx_row_bend *row, const struct dx_row_sigma *sigma)
{
    float more[CELLS], margin[CELLS], more_0[CELLS], margin_0[CELLS];
    float more_here[CELLS], margin_here[CELLS];
    const uint8_t *const *edge = row->outer;
    uint8_t outer[CELLS], all = 1;

    for (uint32_t j = 0; j < CELLS; j++) {
        outer[j] = edge[0][j] & edge[1][j] & edge[2][j] & edge[3][j];
        all &= outer[j];
    }
    compare_bends(more, margin, row, sigma);
    if (all) {
        tell(prefer_bd, unsure, more, margin);
        return;
    }
    compare_corners(more_0, margin_0, row, sigma);
    choose_lanes(more_here, more, more_0, outer);
    choose_lanes(margin_here, margin, margin_0, outer);
    tell(prefer_bd, unsure, more_here, margin_here);
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
