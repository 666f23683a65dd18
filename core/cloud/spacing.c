/* Spacing and noise by medians over a sample. */
#include "core/cloud/spacing.h"

#include "core/cloud/sample.h"
#include "core/cloud/sym3.h"

#include <math.h>
#include <stdbool.h>

#define N_NEAR  20 /* of a fit */
#define N_TERMS 6  /* 1 x y xx xy yy */

double dx_cloud_spacing(const struct dx_cloud *c)
{
    struct dx_sample_median m = {.n = 0};

    for (uint32_t k = 0; k < dx_sample_n(c); k++) {
        struct dx_near near;

        if (dx_cloud_nearest(c, dx_sample_rank(c, k), 1, &near))
            dx_sample_insert(&m, sqrt((double)near.d2));
    }
    return m.n ? m.value[m.n / 2] : 1;
}

/* Solves a x = b by elimination with pivots; false: singular. b becomes x. */
static bool solve(double a[N_TERMS][N_TERMS], double b[N_TERMS])
{
    for (int k = 0; k < N_TERMS; k++) {
        int pivot = k;

        for (int i = k + 1; i < N_TERMS; i++)
            if (fabs(a[i][k]) > fabs(a[pivot][k]))
                pivot = i;
        if (!(fabs(a[pivot][k]) > 1e-12))
            return false;
        for (int j = 0; j < N_TERMS; j++) {
            const double held = a[k][j];

            a[k][j] = a[pivot][j];
            a[pivot][j] = held;
        }
        const double held = b[k];

        b[k] = b[pivot];
        b[pivot] = held;
        for (int i = 0; i < N_TERMS; i++) {
            const double f = i == k ? 0 : a[i][k] / a[k][k];

            for (int j = k; j < N_TERMS; j++)
                a[i][j] -= f * a[k][j];
            b[i] -= f * b[k];
        }
    }
    for (int k = 0; k < N_TERMS; k++)
        b[k] /= a[k][k];
    return true;
}

/* Points about their mean, in their principal axes over their extent: x, y, height. */
static double turn(double p[N_NEAR + 1][3], const struct dx_cloud *c, uint32_t rank,
                   const struct dx_near *near)
{
    double mean[3] = {0}, size;
    struct dx_sym3 s = {{0}};
    struct dx_eigen3 e;

    for (int k = 0; k <= N_NEAR; k++)
        for (int i = 0; i < 3; i++) {
            const uint32_t r = k < N_NEAR ? near[k].rank : rank;

            p[k][i] = c->at[r][i] - c->at[rank][i];
            mean[i] += p[k][i] / (N_NEAR + 1);
        }
    for (int k = 0; k <= N_NEAR; k++) {
        for (int i = 0; i < 3; i++)
            p[k][i] -= mean[i];
        for (int i = 0, m = 0; i < 3; i++)
            for (int j = i; j < 3; j++, m++)
                s.m[m] += p[k][i] * p[k][j];
    }
    dx_sym3_eigen(&e, &s);
    size = sqrt(e.value[2] / N_NEAR);
    for (int k = 0; k <= N_NEAR && size > 0; k++) {
        const double v[3] = {p[k][0], p[k][1], p[k][2]};

        for (int i = 0; i < 3; i++) {
            const double *axis = e.vector[2 - i];

            p[k][i] = (axis[0] * v[0] + axis[1] * v[1] + axis[2] * v[2]) / size;
        }
    }
    return size;
}

/* Standard deviation from the paraboloid; negative: there is none. */
static double residual(double p[N_NEAR + 1][3])
{
    double a[N_TERMS][N_TERMS] = {{0}}, b[N_TERMS] = {0}, sum = 0;

    for (int pass = 0; pass < 2; pass++) {
        for (int k = 0; k <= N_NEAR; k++) {
            const double x = p[k][0], y = p[k][1];
            const double term[N_TERMS] = {1, x, y, x * x, x * y, y * y};
            double height = p[k][2];

            for (int i = 0; i < N_TERMS; i++) {
                for (int j = 0; j < N_TERMS && pass == 0; j++)
                    a[i][j] += term[i] * term[j];
                if (pass == 0)
                    b[i] += term[i] * height;
                else
                    height -= b[i] * term[i];
            }
            sum += pass ? height * height : 0;
        }
        if (pass == 0 && !solve(a, b))
            return -1;
    }
    return sqrt(sum / (N_NEAR + 1 - N_TERMS));
}

double dx_cloud_noise(const struct dx_cloud *c)
{
    struct dx_sample_median m = {.n = 0};

    for (uint32_t k = 0; c->n > N_NEAR && k < dx_sample_n(c); k++) {
        struct dx_near near[N_NEAR];
        double p[N_NEAR + 1][3], size, r;

        dx_cloud_nearest(c, dx_sample_rank(c, k), N_NEAR, near);
        size = turn(p, c, dx_sample_rank(c, k), near);
        r = size > 0 ? residual(p) : -1;
        if (r >= 0)
            dx_sample_insert(&m, size * r);
    }
    return m.n ? m.value[m.n / 2] : 0;
}
