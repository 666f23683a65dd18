/*
 * The loops of rows.h that filter samples: what nearly all dexels of a scene do that stands still,
 * and which ones do something else. Included once by each rows_SET.c. All lanes have 32 bits.
 */
#include "core/rows/rows.h"

/* Differences below it, and what half of a divisor adds, divide exactly in f32: a quotient that is
 * no whole number is further from the next one than it is rounded. */
#define DIVIDES (UINT32_C(1) << 22)

/* A part of sigma that its integers have for sure. */
static inline float least_sigma(const struct dx_row_sigma *s, float r)
{
    float sigma = (float)s->a0 + r * ((float)s->a1 + r * (float)s->a2), max = (float)s->max;

    return (sigma < max ? sigma : max) * (1 - 0x1p-19f) - (float)s->off;
}

static uint64_t join_mean_row(uint32_t *restrict est, uint32_t *restrict state,
                              const uint32_t *restrict range, const struct dx_row_mean *mean)
{
    const struct dx_row_sigma sigma = mean->sigma;
    const uint32_t surely_near = mean->surely_near, n_max = mean->n_max;
    const float gate = (float)mean->gate;
    uint32_t left[CELLS];

    for (uint32_t j = 0; j < CELLS; j++) {
        const uint32_t r = range[j], e = est[j], s = state[j], sample = r << 8;
        const uint32_t down = sample < e, d = down ? e - sample : sample - e;
        const uint32_t n = (s & 0xff) + ((s & 0xff) < n_max);
        const uint32_t divides = d < DIVIDES, dividend = divides ? d + ((n - down) >> 1) : 0;
        const uint32_t step = (uint32_t)(int32_t)((float)(int32_t)dividend / (float)(int32_t)n);
        const float far = gate * least_sigma(&sigma, (float)(int32_t)(e >> 8));
        const uint32_t near =
            (uint32_t)(d <= surely_near) | (uint32_t)((float)(int32_t)(d & (DIVIDES - 1)) <= far);
        const uint32_t joins = (uint32_t)(r != 0) & (uint32_t)(r < UINT32_C(1) << 24) &
                               (uint32_t)((s & 0xff) != 0) & divides & near;

        est[j] = joins ? (down ? e - step : e + step) : e;
        state[j] = joins ? n : s;
        left[j] = joins | (uint32_t)((r | e) == 0) ? 0 : UINT32_MAX;
    }
    return (uint64_t)pack32(left, CELLS);
}

static void tell_mean_row(uint32_t *restrict estimate, uint32_t *restrict range,
                          const uint32_t *restrict est, const uint32_t *restrict state)
{
    for (uint32_t j = 0; j < CELLS; j++) {
        const uint32_t far = (uint32_t)((state[j] & 0xff) == 0) & (uint32_t)(est[j] != 0);

        estimate[j] = far ? UINT32_MAX : est[j];
        range[j] = far ? est[j] : (est[j] + 128) >> 8;
    }
}

static void median3_row(uint32_t *restrict median, const uint32_t *restrict x,
                        const uint32_t *restrict y, const uint32_t *restrict z)
{
    for (uint32_t j = 0; j < CELLS; j++) {
        const uint32_t lo = x[j] < y[j] ? x[j] : y[j], hi = x[j] < y[j] ? y[j] : x[j];
        const uint32_t hi_z = hi < z[j] ? hi : z[j];

        median[j] = lo > hi_z ? lo : hi_z;
    }
}

static uint64_t may_have_moved_row(const uint32_t *restrict estimate,
                                   const uint32_t *restrict published,
                                   const struct dx_row_hold *hold)
{
    const struct dx_row_sigma sigma = hold->sigma;
    const uint32_t surely_held = hold->surely_held;
    const float sigmas = (float)hold->sigmas;
    uint32_t may[CELLS];

    for (uint32_t j = 0; j < CELLS; j++) {
        const uint32_t e = estimate[j], p = published[j], at = p << 8;
        const uint32_t d = e < at ? at - e : e - at;
        const float held = sigmas * least_sigma(&sigma, (float)(int32_t)(p & 0xffffff)) - 1;
        const uint32_t told = (uint32_t)((e != 0) == (p != 0)) & (uint32_t)(e != UINT32_MAX) &
                              (uint32_t)(p < 1u << 24);
        const uint32_t within =
            (uint32_t)(d <= surely_held) | (uint32_t)((e + 128) >> 8 == p) |
            ((uint32_t)(d < DIVIDES) & (uint32_t)((float)(int32_t)(d & (DIVIDES - 1)) <= held));

        may[j] = told & within ? 0 : UINT32_MAX;
    }
    return (uint64_t)pack32(may, CELLS);
}

#undef DIVIDES
