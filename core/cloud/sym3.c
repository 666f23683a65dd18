/* Cyclic Jacobi: each rotation makes one element off the diagonal 0; a few sweeps make all so. */
#include "core/cloud/sym3.h"

#include <math.h>

#define MAX_SWEEPS 32

/* The rotation of rows and columns p and q, that makes a[p][q] 0. */
static void rotate(double a[3][3], double v[3][3], int p, int q)
{
    const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
    const double t = (theta < 0 ? -1 : 1) / (fabs(theta) + sqrt(theta * theta + 1));
    const double c = 1 / sqrt(t * t + 1), s = t * c;

    for (int k = 0; k < 3; k++) {
        const double x = a[k][p], y = a[k][q];

        a[k][p] = c * x - s * y;
        a[k][q] = s * x + c * y;
    }
    for (int k = 0; k < 3; k++) {
        const double x = a[p][k], y = a[q][k];

        a[p][k] = c * x - s * y;
        a[q][k] = s * x + c * y;
    }
    a[p][q] = a[q][p] = 0;
    for (int k = 0; k < 3; k++) {
        const double x = v[p][k], y = v[q][k];

        v[p][k] = c * x - s * y;
        v[q][k] = s * x + c * y;
    }
}

static void exchange(struct dx_eigen3 *e, int i, int j)
{
    const double value = e->value[i];

    if (e->value[i] <= e->value[j])
        return;
    e->value[i] = e->value[j];
    e->value[j] = value;
    for (int k = 0; k < 3; k++) {
        const double x = e->vector[i][k];

        e->vector[i][k] = e->vector[j][k];
        e->vector[j][k] = x;
    }
}

void dx_sym3_eigen(struct dx_eigen3 *e, const struct dx_sym3 *s)
{
    const double *m = s->m;
    double a[3][3] = {{m[0], m[1], m[2]}, {m[1], m[3], m[4]}, {m[2], m[4], m[5]}};
    double v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

    for (int sweep = 0; sweep < MAX_SWEEPS; sweep++) {
        const double off = fabs(a[0][1]) + fabs(a[0][2]) + fabs(a[1][2]);

        if (!(off > 1e-15 * (fabs(a[0][0]) + fabs(a[1][1]) + fabs(a[2][2]))))
            break;
        for (int p = 0; p < 2; p++)
            for (int q = p + 1; q < 3; q++)
                if (a[p][q] != 0)
                    rotate(a, v, p, q);
    }
    for (int k = 0; k < 3; k++) {
        e->value[k] = a[k][k];
        for (int i = 0; i < 3; i++)
            e->vector[k][i] = v[k][i];
    }
    exchange(e, 0, 1);
    exchange(e, 1, 2);
    exchange(e, 0, 1);
    for (int k = 0; k < 3; k++) { /* an exchange mirrors */
        const double *x = e->vector[0], *y = e->vector[1];

        e->vector[2][k] = x[(k + 1) % 3] * y[(k + 2) % 3] - x[(k + 2) % 3] * y[(k + 1) % 3];
    }
}
