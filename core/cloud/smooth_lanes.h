/* Loops over points take two at a time: as many doubles as every processor of ours has in a
 * register, so that sums have the same order, and results the same bits, everywhere. */
#ifndef DX_SMOOTH_LANES_H
#define DX_SMOOTH_LANES_H

#include <stdint.h>
#include <string.h>

typedef double dx_lanes __attribute__((vector_size(16)));

static inline dx_lanes dx_lanes_all(double x)
{
    return (dx_lanes){x, x};
}

static inline dx_lanes dx_lanes_at(const double *v, uint32_t i)
{
    dx_lanes x;

    memcpy(&x, v + i, sizeof(x));
    return x;
}

static inline void dx_lanes_put(double *v, uint32_t i, dx_lanes x)
{
    memcpy(v + i, &x, sizeof(x));
}

/* w exp(-x), x not negative: over a power of a polynomial, which takes it to 0 for large x without
 * a branch. Relative error below 1e-8 to x = 8. */
static inline dx_lanes dx_lanes_times_exp_minus(dx_lanes w, dx_lanes x)
{
    const dx_lanes u = x * (1.0 / 64);
    dx_lanes e = 1 + u * (1 + u * (1.0 / 2 + u * (1.0 / 6 + u * (1.0 / 24 + u * (1.0 / 120)))));

    for (int k = 0; k < 6; k++)
        e *= e;
    return w / e;
}

#endif
