/* Geometry that refining and flipping share. */
#ifndef DX_REFINE_PRIV_H
#define DX_REFINE_PRIV_H

#include "core/cloud/refine.h"

static inline double dx_refine_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline double dx_refine_len2(const double a[3], const double b[3])
{
    const double d[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};

    return dx_refine_dot(d, d);
}

/* Unit normal of triangle (a, b, c), or 0 0 0. */
void dx_refine_normal(double n[3], const double a[3], const double b[3], const double c[3]);

#endif
