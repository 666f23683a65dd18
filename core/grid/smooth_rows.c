/*
 * The robust mean by iterated weights (Tukey's, which are polynomials). It starts at the own sample
 * and so finds the nearest of several answers: at a crease that of the pairs along it, not that of
 * the majority across it. Loops without a branch over rows of floats, which compilers make vectors
 * of.
 */
#include "core/grid/smooth_rows.h"

#include <string.h>

#define STEPS  3
#define CUTOFF 3.5f /* sigmas from where on a pair has no weight; it tells with a noise of 0.7 */

/* 2 exp(-d^2 / (2 * 1.2^2)) for a pair of distance d; the corners of 5 x 5 would count 0.12. */
const struct dx_smooth_pair dx_smooth_pairs[DX_SMOOTH_PAIRS] = {
    {0, 1, 1.413f}, {1, 0, 1.413f}, {1, 1, 0.999f},  {1, -1, 0.999f}, {0, 2, 0.499f},
    {2, 0, 0.499f}, {1, 2, 0.352f}, {1, -2, 0.352f}, {2, 1, 0.352f},  {2, -1, 0.352f},
};

/* x, or 0 where it is negative. On the bits: compilers make no vectors of comparisons that could
 * trap. */
static inline float above_zero(float x)
{
    int32_t bits;

    memcpy(&bits, &x, sizeof(bits));
    bits &= ~(bits >> 31);
    memcpy(&x, &bits, sizeof(x));
    return x;
}

void dx_smooth_row_scale(struct dx_smooth_row *r, const uint32_t *range,
                         const struct dx_sigma *sigma, double noise)
{
    const float per_unit = (float)(noise / 256);

    for (uint32_t j = 0; j < r->n; j++) {
        const float s = per_unit * (float)dx_sigma_at(sigma, range[j]);

        r->sigma[j] = s > 0.5f ? s : 0.5f; /* ranges are rounded */
    }
    for (uint32_t j = 0; j < r->n; j++) {
        const float x = (float)range[j];

        r->scale[j] = x * x / (CUTOFF * r->sigma[j]);
    }
}

void dx_smooth_row_even(struct dx_smooth_row *r, unsigned k, const struct dx_smooth_ends *inverse,
                        struct dx_smooth_line line)
{
    const float *before = inverse->before, *own = inverse->own, *after = inverse->after;
    float *out = r->pair[k].departure;

    for (uint32_t j = 0; j < r->n; j++)
        out[j] = (line.minus * before[j] + line.plus * after[j] - own[j]) * r->scale[j];
}

/*
 * The line by the dexels' own directions: by where the own one stands between the two others (x of
 * the way), and by how much an arc is off its chord: sin a + sin b of sin (a + b) is 1 + a b / 2.
 */
static void tell_uneven(float *restrict out, const float *scale, struct dx_smooth_ends q,
                        struct dx_smooth_ends a, struct dx_smooth_ends b, struct dx_smooth_ends c,
                        float arc, uint32_t n)
{
    for (uint32_t j = 0; j < n; j++) {
        const float tx = a.after[j] - a.before[j], ty = b.after[j] - b.before[j];
        const float tz = c.after[j] - c.before[j];
        const float along = (a.own[j] - a.before[j]) * tx + (b.own[j] - b.before[j]) * ty +
                            (c.own[j] - c.before[j]) * tz;
        const float length2 = tx * tx + ty * ty + tz * tz;
        const float y = above_zero(1 - above_zero(along / (length2 + 1e-30f)));
        const float x = 1 - y; /* outside 0..1 only in crooked tables */
        const float told = (1 + arc * x * y * length2) * (y * q.before[j] + x * q.after[j]);

        out[j] = (told - q.own[j]) * scale[j];
    }
}

void dx_smooth_row_uneven(struct dx_smooth_row *r, unsigned k, const struct dx_smooth_ends *inverse,
                          const struct dx_smooth_ends d[3], bool depths)
{
    tell_uneven(r->pair[k].departure, r->scale, *inverse, d[0], d[1], d[2], depths ? 0 : 0.5f,
                r->n);
}

void dx_smooth_row_weigh(struct dx_smooth_row *r, unsigned k, const uint8_t *joined)
{
    const float weight = dx_smooth_pairs[k].weight;
    float *out = r->pair[k].weight;

    for (uint32_t j = 0; j < r->n; j++)
        out[j] = weight * (float)joined[j];
}

static void add_pair(float *restrict total, float *restrict sum, const float *shift,
                     const float *departure, const float *weight, uint32_t n)
{
    for (uint32_t j = 0; j < n; j++) {
        const float off = departure[j] - shift[j], near = above_zero(1 - off * off);
        const float w = near * near * weight[j];

        total[j] += w;
        sum[j] += w * departure[j];
    }
}

void dx_smooth_row_solve(struct dx_smooth_row *r)
{
    const float most = DX_SMOOTH_MAX_MOVE / CUTOFF;

    for (uint32_t j = 0; j < r->n; j++)
        r->shift[j] = 0;
    for (int step = 0; step < STEPS; step++) {
        for (uint32_t j = 0; j < r->n; j++) {
            r->total[j] = 1; /* the own sample, whose departure is 0 */
            r->sum[j] = 0;
        }
        for (unsigned k = 0; k < DX_SMOOTH_PAIRS; k++)
            add_pair(r->total, r->sum, r->shift, r->pair[k].departure, r->pair[k].weight, r->n);
        for (uint32_t j = 0; j < r->n; j++)
            r->shift[j] = r->sum[j] / r->total[j];
    }
    for (uint32_t j = 0; j < r->n; j++) {
        const float s =
            most - above_zero(most - r->shift[j]); /* at most that, then at least minus */

        r->move[j] = (above_zero(s + most) - most) * CUTOFF * r->sigma[j];
    }
}
