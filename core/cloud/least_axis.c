/* Least eigenvalue by Newton's iteration; its eigenvector by a cross product of rows. */
#include "core/cloud/least_axis.h"

#include <math.h>

#define MAX_STEPS 12
#define CLEAR     1e-4 /* of the trace, squared: eigenvalues that are so far apart */
#define THIN      1e-6 /* points whose second extent is less, of the first, are on a line */

static void cross(double out[3], const double a[3], const double b[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The least root of x^3 - x^2 + c x - d, all of whose roots are real and not negative: from the
 * left of it the iteration never passes it. */
static double least_root(double c, double d)
{
    double x = 0;

    for (int k = 0; k < MAX_STEPS; k++) {
        const double f = ((x - 1) * x + c) * x - d, slope = (3 * x - 2) * x + c;
        double step;

        if (!(f < 0) || !(slope > 0))
            break;
        step = f / slope;
        x -= step;
        if (-step < 1e-12)
            break;
    }
    return x;
}

static bool by_rotations(double axis[3], double *share, const struct dx_sym3 *s)
{
    struct dx_eigen3 e;

    dx_sym3_eigen(&e, s);
    if (!(e.value[1] > THIN * e.value[2]))
        return false;
    for (int k = 0; k < 3; k++)
        axis[k] = e.vector[0][k];
    *share = e.value[0] > 0 ? e.value[0] / (e.value[0] + e.value[1] + e.value[2]) : 0;
    return true;
}

bool dx_least_axis(double axis[3], double *share, const struct dx_sym3 *covariance)
{
    const double *m = covariance->m, trace = m[0] + m[3] + m[5];
    double a[6], rows[3][3], out[3][3], len[3], c, d, x;
    int best = 0;

    if (!(trace > 0))
        return false;
    for (int k = 0; k < 6; k++)
        a[k] = m[k] / trace;
    c = a[0] * a[3] - a[1] * a[1] + a[0] * a[5] - a[2] * a[2] + a[3] * a[5] - a[4] * a[4];
    d = a[0] * (a[3] * a[5] - a[4] * a[4]) - a[1] * (a[1] * a[5] - a[4] * a[2]) +
        a[2] * (a[1] * a[4] - a[3] * a[2]);
    x = least_root(c, d);
    for (int i = 0, k = 0; i < 3; i++)
        for (int j = i; j < 3; j++, k++)
            rows[i][j] = rows[j][i] = a[k] - (i == j ? x : 0);
    for (int k = 0; k < 3; k++) {
        cross(out[k], rows[(k + 1) % 3], rows[(k + 2) % 3]);
        len[k] = dot(out[k], out[k]);
        best = len[k] > len[best] ? k : best;
    }
    /* the product of the other two eigenvalues less this one, squared */
    if (!(len[best] > CLEAR * CLEAR))
        return by_rotations(axis, share, covariance);
    for (int k = 0; k < 3; k++)
        axis[k] = out[best][k] / sqrt(len[best]);
    *share = x;
    return true;
}
