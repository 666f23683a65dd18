/* Clouds that are not as the modes assume: all of these must come out manifold, or not at all. Each
 * is to be freed. */
#ifndef ODD_CLOUDS_H
#define ODD_CLOUDS_H

#include "core/base/rng.h"

#include <math.h>
#include <stdlib.h>

static inline double *odd_room(uint32_t n)
{
    double *xyz = malloc(3 * (size_t)n * sizeof(*xyz));

    assert_non_null(xyz);
    return xyz;
}

/* side * side points: all of a row on a line, all of a square on a circle, all in a plane, which is
 * tilted or level; exact in the lattice. */
static inline double *odd_plane_grid(uint32_t side, bool tilted)
{
    double *xyz = odd_room(side * side);

    for (uint32_t k = 0; k < side * side; k++) {
        const uint32_t row = k / side, col = k % side;
        const double x = col, y = row;

        xyz[3 * k] = tilted ? 3 * x - 2 * y : x;
        xyz[3 * k + 1] = tilted ? 2 * x + 3 * y : y;
        xyz[3 * k + 2] = tilted ? 7 * x + 4 * y : 5;
    }
    return xyz;
}

/* A sphere sampled 300 times denser at one pole than at the other. */
static inline double *odd_uneven_sphere(uint32_t n)
{
    double *xyz = odd_room(n);

    for (uint32_t k = 0; k < n; k++) {
        const double share = (k + 0.5) / n, c = 1 - 2 * share * share * share;
        const double s = sqrt(1 - c * c), a = 2.39996322972865332 * k;

        xyz[3 * k] = s * cos(a);
        xyz[3 * k + 1] = s * sin(a);
        xyz[3 * k + 2] = c;
    }
    return xyz;
}

/* No surface: points in a cube; or all but one in a cluster, and that one far away. */
static inline double *odd_volume(uint32_t n, bool clustered, struct dx_rng *g)
{
    double *xyz = odd_room(n);

    for (uint32_t k = 0; k < 3 * n; k++)
        xyz[k] = dx_rng_unit(g) * (clustered ? 1e-6 : 1);
    if (clustered)
        xyz[0] = xyz[1] = xyz[2] = 1000;
    return xyz;
}

/* Turned by 1 radian about x and 2 about z, then shifted: no axis stays one. */
static inline void odd_move(double *xyz, uint32_t n)
{
    const double c = cos(1), s = sin(1), d = cos(2), t = sin(2);

    for (uint32_t k = 0; k < n; k++) {
        double *p = xyz + 3 * (size_t)k, y = c * p[1] - s * p[2], x = p[0];

        p[2] = s * p[1] + c * p[2] + 7;
        p[0] = d * x - t * y - 3;
        p[1] = t * x + d * y + 5;
    }
}

#endif
