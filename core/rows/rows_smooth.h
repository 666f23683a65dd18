/*
 * The loops of smoother.h: the robust mean by iterated weights (Tukey's, which are polynomials). It
 * starts at the own sample and so finds the nearest of several answers: at a crease that of the
 * pairs along it, not that of the majority across it; but for stray samples that nothing speaks
 * for. Included once by each rows_SET.c.
 */
#include "core/rows/smoother.h"

#include <string.h>

#define STEPS    3
#define FAR_BITS 0x44800000 /* FAR, 1024 cutoffs: farther departures are not told apart */
#define TINY     1e-30f     /* keeps 0 / 0 from being no number */
#define CUTOFF   3.5f /* sigmas from where on a pair has no weight; it tells with a noise of 0.7 */

/* Selecting is done on the bits: integers compare faster. */
static inline int32_t bits_of(float x)
{
    int32_t bits;

    memcpy(&bits, &x, sizeof(bits));
    return bits;
}

static inline float float_of(int32_t bits)
{
    float x;

    memcpy(&x, &bits, sizeof(x));
    return x;
}

/* x, or 0 where it is negative. */
static inline float above_zero(float x)
{
    const int32_t bits = bits_of(x);

    return float_of(bits & ~(bits >> 31));
}

/* x, or FAR with its sign; that too for what is no number. */
static inline float within_far(float x)
{
    const int32_t bits = bits_of(x), size = bits & INT32_MAX;

    return float_of((bits & INT32_MIN) | (size < FAR_BITS ? size : FAR_BITS));
}

static void smooth_noise(uint32_t *restrict out, const uint32_t *range,
                         const struct dx_smooth_noise *s, uint32_t n)
{
    const struct dx_smooth_noise f = *s;

    for (uint32_t j = 0; j < n; j++) {
        const uint32_t r = range[j] < f.full ? range[j] : f.full, square = r * r >> 16;
        const uint64_t v = f.a0 + ((uint64_t)r * f.a1 >> 16) + ((uint64_t)square * f.a2 >> 16);

        out[j] = v < f.max ? (uint32_t)v : f.max;
    }
}

static void smooth_invert(float *restrict out, const uint32_t *range, uint32_t n)
{
    for (uint32_t j = 0; j < n; j++)
        out[j] = 1 / (float)(range[j] | (range[j] == 0));
}

static void smooth_scale(struct dx_smooth_row *restrict r, const uint32_t *range,
                         const uint32_t *sigma8, float per_unit)
{
    for (uint32_t j = 0; j < r->n; j++) {
        const float s = per_unit * (float)sigma8[j];

        r->sigma[j] = s > 0.5f ? s : 0.5f; /* ranges are rounded */
    }
    for (uint32_t j = 0; j < r->n; j++) {
        const float x = (float)range[j];

        r->scale[j] = x * x / (CUTOFF * r->sigma[j]);
    }
}

static void smooth_even(struct dx_smooth_row *restrict r, unsigned k,
                        const struct dx_smooth_ends *inverse, struct dx_smooth_line line)
{
    const float *before = inverse->before, *own = inverse->own, *after = inverse->after;
    float *out = r->departure[k];

    for (uint32_t j = 0; j < r->n; j++)
        out[j] = within_far((line.minus * before[j] + line.plus * after[j] - own[j]) * r->scale[j]);
}

/* `value` where a row is so, 0 elsewhere; n as in struct dx_smooth_row. */
static inline void spread(float *restrict out, dx_bits is, float value, uint32_t n)
{
    const int32_t bits = bits_of(value);
    uint32_t lanes[DX_ROWS_N];

    unpack32(lanes, is);
    for (uint32_t j = 0; j < n; j++)
        out[j] = float_of((int32_t)lanes[j] & bits);
}

/* What lies between the neighbours that are joined: both, one and the own, or nothing. */
static void difference(float *restrict out, struct dx_smooth_ends x, const float *joined_before,
                       const float *joined_after, uint32_t n)
{
    for (uint32_t j = 0; j < n; j++)
        out[j] =
            joined_before[j] * (x.own[j] - x.before[j]) + joined_after[j] * (x.after[j] - x.own[j]);
}

/*
 * From differences along row and column (a with inverse ranges p, b with q): the vector in their
 * plane that has p along a and q along b. Where they are nearly parallel, or one is missing, it is
 * damped to nothing.
 */
static void solve_slope(float (*restrict out)[DX_SMOOTH_ROW], const float (*a)[DX_SMOOTH_ROW],
                        const float (*b)[DX_SMOOTH_ROW], const float *p, const float *q, uint32_t n)
{
    for (uint32_t j = 0; j < n; j++) {
        const float aa = a[0][j] * a[0][j] + a[1][j] * a[1][j] + a[2][j] * a[2][j];
        const float ab = a[0][j] * b[0][j] + a[1][j] * b[1][j] + a[2][j] * b[2][j];
        const float bb = b[0][j] * b[0][j] + b[1][j] * b[1][j] + b[2][j] * b[2][j];
        const float det = aa * bb * 1.001f - ab * ab + TINY;
        const float of_a = (bb * p[j] - ab * q[j]) / det, of_b = (aa * q[j] - ab * p[j]) / det;

        for (int k = 0; k < 3; k++)
            out[k][j] = of_a * a[k][j] + of_b * b[k][j];
    }
}

static void smooth_slope(struct dx_smooth_row *restrict r, const struct dx_smooth_cross *cross)
{
    float step[2][3][DX_SMOOTH_ROW], rise[2][DX_SMOOTH_ROW];

    for (int e = 0; e < 2; e++) {
        float before[DX_SMOOTH_ROW], after[DX_SMOOTH_ROW];

        spread(before, cross->joined_before[e], 1, r->n);
        spread(after, cross->joined_after[e], 1, r->n);
        for (int k = 0; k < 3; k++)
            difference(step[e][k], cross->direction[e][k], before, after, r->n);
        difference(rise[e], cross->inverse[e], before, after, r->n);
    }
    solve_slope(r->slope, step[0], step[1], rise[0], rise[1], r->n);
}

/*
 * The line by the dexels' own directions a, b, c: by where the own one stands between the two
 * others (x of the way); by how much an arc is off its chord (sin a + sin b of sin (a + b) is 1 + a
 * b / 2); and by how far the three are off one line, along the slope.
 */
static void tell_uneven(float *restrict out, const struct dx_smooth_row *r, struct dx_smooth_ends q,
                        struct dx_smooth_ends a, struct dx_smooth_ends b, struct dx_smooth_ends c,
                        float arc)
{
    for (uint32_t j = 0; j < r->n; j++) {
        const float tx = a.after[j] - a.before[j], ty = b.after[j] - b.before[j];
        const float tz = c.after[j] - c.before[j];
        const float ox = a.own[j] - a.before[j], oy = b.own[j] - b.before[j];
        const float oz = c.own[j] - c.before[j];
        const float length2 = tx * tx + ty * ty + tz * tz;
        const float way = (ox * tx + oy * ty + oz * tz) / (length2 + TINY);
        const float y = above_zero(1 - above_zero(way)), x = 1 - y; /* beyond: crooked tables */
        const float line = (1 + arc * x * y * length2) * (y * q.before[j] + x * q.after[j]);
        const float off = (ox - x * tx) * r->slope[0][j] + (oy - x * ty) * r->slope[1][j] +
                          (oz - x * tz) * r->slope[2][j];

        out[j] = within_far((line + off - q.own[j]) * r->scale[j]);
    }
}

static void smooth_uneven(struct dx_smooth_row *r, unsigned k, const struct dx_smooth_ends *inverse,
                          const struct dx_smooth_ends d[3], bool depths)
{
    tell_uneven(r->departure[k], r, *inverse, d[0], d[1], d[2], depths ? 0 : 0.5f);
}

static void smooth_weigh(struct dx_smooth_row *restrict r, unsigned k, dx_bits joined, float weight)
{
    spread(r->weight[k], joined, weight, r->n);
}

/* Sums over the pairs, in one lane: kept in registers, since pairs are written out. */
struct weighed {
    float total, sum;
};

#define EACH_PAIR(s, add, ...)                                                                     \
    do {                                                                                           \
        s = add(s, r, 0, __VA_ARGS__);                                                             \
        s = add(s, r, 1, __VA_ARGS__);                                                             \
        s = add(s, r, 2, __VA_ARGS__);                                                             \
        s = add(s, r, 3, __VA_ARGS__);                                                             \
        s = add(s, r, 4, __VA_ARGS__);                                                             \
        s = add(s, r, 5, __VA_ARGS__);                                                             \
        s = add(s, r, 6, __VA_ARGS__);                                                             \
        s = add(s, r, 7, __VA_ARGS__);                                                             \
        s = add(s, r, 8, __VA_ARGS__);                                                             \
        s = add(s, r, 9, __VA_ARGS__);                                                             \
    } while (0)

static inline __attribute__((always_inline)) struct weighed add_pair(struct weighed to,
                                                                     const struct dx_smooth_row *r,
                                                                     unsigned k, uint32_t j,
                                                                     float shift)
{
    const float departure = r->departure[k][j];
    const float off = departure - shift, near = above_zero(1 - off * off);
    const float w = near * near * r->weight[k][j];

    return (struct weighed){to.total + w, to.sum + w * departure};
}

/* One step: the mean by the weights that the pairs have as seen from the last one. */
static void step(struct dx_smooth_row *restrict r)
{
    const uint32_t n = r->n;

    for (uint32_t j = 0; j < n; j++) {
        const float shift = r->shift[j];
        struct weighed s = {1, 0}; /* the own sample, whose departure is 0 */

        EACH_PAIR(s, add_pair, j, shift);
        r->shift[j] = s.sum / s.total;
    }
}

/* What all pairs tell, whatever the own sample is. */
struct told {
    float all, sum, squares;
};

static inline __attribute__((always_inline)) struct told add_plainly(struct told to,
                                                                     const struct dx_smooth_row *r,
                                                                     unsigned k, uint32_t j)
{
    const float weight = r->weight[k][j], departure = r->departure[k][j];
    const float told = weight * departure;

    return (struct told){to.all + weight, to.sum + told, to.squares + told * departure};
}

/*
 * The first step, as seen from the own sample. Where the pairs that speak for it count for less
 * than it does itself, and all of them agree on something else, it is a lone stray one: the next
 * step begins at their mean, as far as both is so. (At the corner of a box none speaks for it
 * either, but they do not agree.)
 */
static void step_and_doubt(struct dx_smooth_row *restrict r)
{
    const uint32_t n = r->n;

    for (uint32_t j = 0; j < n; j++) {
        struct weighed s = {1, 0};
        struct told t = {0, 0, 0};
        float mean, spread2;

        EACH_PAIR(s, add_pair, j, 0);
        EACH_PAIR(t, add_plainly, j);
        mean = t.sum / (t.all + TINY);
        spread2 = t.squares / (t.all + TINY) - mean * mean;
        r->shift[j] =
            s.sum / s.total + above_zero(2 - s.total) * above_zero(1 - 4 * spread2) * mean;
    }
}

static void smooth_solve(struct dx_smooth_row *restrict r, float max_move)
{
    const float most = max_move / CUTOFF;
    const uint32_t n = r->n;

    step_and_doubt(r);
    for (int k = 1; k < STEPS; k++)
        step(r);
    for (uint32_t j = 0; j < n; j++) { /* at most so far ahead, at most so far back */
        const float s = most - above_zero(most - r->shift[j]);
        const float move = (above_zero(s + most) - most) * CUTOFF * r->sigma[j];

        r->move[j] = (int32_t)(move + float_of(bits_of(0.5f) | (bits_of(move) & INT32_MIN)));
    }
}

#define DX_SMOOTHER                                                                                \
    {                                                                                              \
        .noise = smooth_noise, .invert = smooth_invert, .scale = smooth_scale,                     \
        .slope = smooth_slope, .even = smooth_even, .uneven = smooth_uneven,                       \
        .weigh = smooth_weigh, .solve = smooth_solve,                                              \
    }
