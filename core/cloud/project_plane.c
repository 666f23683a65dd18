/*
 * The projection plane (section 4.1): by the mean normal of the triangles around r, as the paper
 * has it, or fitted to the points near r, with the side taken from its neighbours. Of the fitted
 * one the variant of section 6.1 takes the nearest plane of two axes, which needs no rotation.
 */
#include "core/cloud/project_priv.h"

#include "core/cloud/sym3.h"

#include <math.h>

#define THIN 1e-6 /* points whose second extent is less, of the first, are on a line */

static void offset(double d[3], const struct dx_project_run *run, uint32_t rank)
{
    for (int k = 0; k < 3; k++)
        d[k] = run->cloud->at[rank][k] - run->cloud->at[run->r][k];
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static bool normalise(double n[3])
{
    const double len = sqrt(dot(n, n));

    if (!(len > 0))
        return false;
    for (int k = 0; k < 3; k++)
        n[k] /= len;
    return true;
}

/* u and v, so that u, v, normal are right-handed. */
static void set_basis(struct dx_project_run *run)
{
    const double *n = run->normal;
    double *u = run->u, *v = run->v;
    int least = fabs(n[0]) <= fabs(n[1]) ? 0 : 1;
    int a, b;

    least = fabs(n[2]) < fabs(n[least]) ? 2 : least;
    a = (least + 1) % 3;
    b = (least + 2) % 3;
    u[least] = 0;
    u[a] = n[b];
    u[b] = -n[a];
    normalise(u);
    for (int k = 0; k < 3; k++)
        v[k] = n[(k + 1) % 3] * u[(k + 2) % 3] - n[(k + 2) % 3] * u[(k + 1) % 3];
}

/* The side of a first normal: towards the viewpoint, or +depth. */
static double side_of(const struct dx_project_run *run, const double n[3])
{
    const struct dx_cloud *c = run->cloud;
    double to[3];

    if (!run->config->viewpoint)
        return n[2] != 0 ? n[2] : n[0] != 0 ? n[0] : n[1];
    for (int k = 0; k < 3; k++)
        to[k] = (run->config->viewpoint[c->axis[k]] - c->origin[k]) / c->step - c->at[run->r][k];
    return dot(n, to);
}

/* Of the points near r, about their mean: for a seed. */
static bool principal(struct dx_project_run *run)
{
    double sum[3] = {0}, d[3];
    const double n = run->n_near + 1;
    struct dx_sym3 m = {{0}};
    struct dx_eigen3 e;
    double sign;

    for (uint32_t k = 0; k < run->n_near; k++) {
        offset(d, run, run->near[k].rank);
        for (int i = 0; i < 3; i++)
            sum[i] += d[i];
        m.m[0] += d[0] * d[0];
        m.m[1] += d[0] * d[1];
        m.m[2] += d[0] * d[2];
        m.m[3] += d[1] * d[1];
        m.m[4] += d[1] * d[2];
        m.m[5] += d[2] * d[2];
    }
    for (int i = 0, k = 0; i < 3; i++)
        for (int j = i; j < 3; j++, k++)
            m.m[k] -= sum[i] * sum[j] / n;
    dx_sym3_eigen(&e, &m);
    if (run->n_near < 2 || !(e.value[1] > THIN * e.value[2]))
        return false;
    sign = side_of(run, e.vector[0]) < 0 ? -1 : 1;
    for (int k = 0; k < 3; k++)
        run->normal[k] = sign * e.vector[0][k];
    return true;
}

/* Least squares of the heights over the plane there is, z = a + b x + c y; tilts it. False: it is
 * too steep for that. */
static bool tilt(struct dx_project_run *run)
{
    double x = 0, y = 0, z = 0, xx = 0, xy = 0, yy = 0, xz = 0, yz = 0, det, b, c;
    const double n = run->n_near + 1;

    set_basis(run);
    for (uint32_t k = 0; k < run->n_near; k++) {
        double d[3], p, q, h;

        offset(d, run, run->near[k].rank);
        p = dot(d, run->u);
        q = dot(d, run->v);
        h = dot(d, run->normal);
        x += p;
        y += q;
        z += h;
        xx += p * p;
        xy += p * q;
        yy += q * q;
        xz += p * h;
        yz += q * h;
    }
    xx -= x * x / n;
    xy -= x * y / n;
    yy -= y * y / n;
    xz -= x * z / n;
    yz -= y * z / n;
    det = xx * yy - xy * xy;
    if (!(det > THIN * (xx + yy) * (xx + yy)))
        return false;
    b = (xz * yy - yz * xy) / det;
    c = (yz * xx - xz * xy) / det;
    if (!(b * b + c * c < 3)) /* 60 degrees */
        return false;
    for (int k = 0; k < 3; k++)
        run->normal[k] -= b * run->u[k] + c * run->v[k];
    return normalise(run->normal);
}

/* The axis plane nearest to the normal there is. */
static void snap_to_axis(struct dx_project_run *run)
{
    int most = 0;

    for (int k = 1; k < 3; k++)
        if (fabs(run->normal[k]) > fabs(run->normal[most]))
            most = k;
    for (int k = 0; k < 3; k++) {
        run->u[k] = k == (most + 1) % 3;
        run->v[k] = k == (most + 2) % 3 ? (run->normal[most] < 0 ? -1 : 1) : 0;
    }
}

bool dx_project_set_plane(struct dx_project_run *run)
{
    const struct dx_project_point *p = &run->point[run->r];

    run->scale = DX_PROJECT_FLAT / run->radius;
    for (int k = 0; k < 3; k++)
        run->normal[k] = (double)p->normal[k];
    if (!p->ring || !normalise(run->normal)) {
        if (!principal(run))
            return false;
    }
    if (run->config->plane != DX_PROJECT_FACES) {
        double before[3] = {run->normal[0], run->normal[1], run->normal[2]};

        if (!tilt(run))
            for (int k = 0; k < 3; k++)
                run->normal[k] = before[k];
    }
    set_basis(run);
    if (run->config->plane == DX_PROJECT_AXIS)
        snap_to_axis(run);
    return true;
}

/* To the nearest, halves away from 0. */
static int32_t flat(double x)
{
    const double most = DX_FLAT_MAX / 2;

    x = x < 0 ? x - 0.5 : x + 0.5;
    return (int32_t)(x > most ? most : x < -most ? -most : x);
}

struct dx_flat dx_project_flat(const struct dx_project_run *run, uint32_t rank)
{
    double d[3];

    offset(d, run, rank);
    return (struct dx_flat){flat(dot(d, run->u) * run->scale), flat(dot(d, run->v) * run->scale)};
}
