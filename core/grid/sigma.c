/* The noise model's integer constants. */
#include "core/grid/sigma.h"

#include <math.h>
#include <stdbool.h>

/* A factor this large makes its term reach DX_SIGMA_MAX as soon as what it multiplies is 1, so a
 * larger one is the same. */
#define FACTOR_MAX 0x1p43

static uint64_t factor(double v)
{
    v = rint(v);
    return v < FACTOR_MAX ? (uint64_t)v : (uint64_t)FACTOR_MAX;
}

static bool is_full(const struct dx_sigma *s, uint64_t r)
{
    unsigned __int128 linear = (unsigned __int128)r * s->a1 >> 16;
    unsigned __int128 square = (unsigned __int128)(r * r >> 16) * s->a2 >> 16;

    return s->a0 + linear + square >= DX_SIGMA_MAX;
}

/* The first range at which sigma8 has reached its maximum; it does not fall. */
static uint32_t find_full(const struct dx_sigma *s)
{
    uint32_t lo = 0, hi = UINT32_MAX;

    while (lo < hi) {
        uint32_t mid = lo + (hi - lo) / 2;

        if (is_full(s, mid))
            hi = mid;
        else
            lo = mid + 1;
    }
    return lo;
}

void dx_sigma_init(struct dx_sigma *s, const double sigma[3], double unit_m)
{
    double floor_m = 0.5 * unit_m;

    s->a0 = factor(256 * (sigma[0] > floor_m ? sigma[0] : floor_m) / unit_m);
    s->a1 = factor(0x1p24 * sigma[1]);
    s->a2 = factor(0x1p40 * sigma[2] * unit_m);
    s->full = find_full(s);
}

/* The integers cut each product to a whole number, and the square before it is multiplied. */
struct dx_row_sigma dx_sigma_rows(const struct dx_sigma *s)
{
    const double a1 = (double)s->a1, a2 = (double)s->a2;

    return (struct dx_row_sigma){.a0 = (double)s->a0,
                                 .a1 = a1 * 0x1p-16,
                                 .a2 = a2 * 0x1p-32,
                                 .max = DX_SIGMA_MAX,
                                 .off = 3.01 + a2 * 0x1p-16 * 1.001};
}
