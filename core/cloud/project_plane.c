/*
 * The projection plane (section 4.1): by the mean normal of the triangles around r, as the paper
 * has it, or fitted to the points near r, with the side taken from its neighbours. Of the fitted
 * one the variant of section 6.1 takes the nearest plane of two axes, which needs no rotation.
 */
#include "core/cloud/project_priv.h"

#include "core/cloud/sym3.h"

#include <math.h>
#include <string.h>

#define THIN 1e-6 /* points whose second extent is less, of the first, are on a line */

/* Two doubles at once, to be added up in this order everywhere. */
typedef double two __attribute__((vector_size(16)));

static inline two load(const double *d)
{
    two x;

    memcpy(&x, d, sizeof(x));
    return x;
}

/* Second moments of the points near r, and r, about their mean. */
static struct dx_sym3 moments(struct dx_project_run *run)
{
    const double n = run->n_near + 1;
    two x = {0}, y = {0}, z = {0}, xx = {0}, xy = {0}, xz = {0}, yy = {0}, yz = {0}, zz = {0};

    for (int i = 0; i < 3; i++)
        run->offset[i][run->n_near] = 0;
    for (uint32_t k = 0; k < run->n_near; k += 2) {
        const two dx = load(run->offset[0] + k), dy = load(run->offset[1] + k),
                  dz = load(run->offset[2] + k);

        x += dx;
        y += dy;
        z += dz;
        xx += dx * dx;
        xy += dx * dy;
        xz += dx * dz;
        yy += dy * dy;
        yz += dy * dz;
        zz += dz * dz;
    }
    x[0] += x[1];
    y[0] += y[1];
    z[0] += z[1];
    return (struct dx_sym3){{xx[0] + xx[1] - x[0] * x[0] / n, xy[0] + xy[1] - x[0] * y[0] / n,
                             xz[0] + xz[1] - x[0] * z[0] / n, yy[0] + yy[1] - y[0] * y[0] / n,
                             yz[0] + yz[1] - y[0] * z[0] / n, zz[0] + zz[1] - z[0] * z[0] / n}};
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void times(double out[3], const struct dx_sym3 *s, const double a[3])
{
    const double *m = s->m;

    out[0] = m[0] * a[0] + m[1] * a[1] + m[2] * a[2];
    out[1] = m[1] * a[0] + m[3] * a[1] + m[4] * a[2];
    out[2] = m[2] * a[0] + m[4] * a[1] + m[5] * a[2];
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
    v[0] = n[1] * u[2] - n[2] * u[1];
    v[1] = n[2] * u[0] - n[0] * u[2];
    v[2] = n[0] * u[1] - n[1] * u[0];
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

/* Where the points near r extend least: for a seed. */
static bool principal(struct dx_project_run *run, const struct dx_sym3 *m)
{
    struct dx_eigen3 e;
    double sign;

    dx_sym3_eigen(&e, m);
    if (run->n_near < 2 || !(e.value[1] > THIN * e.value[2]))
        return false;
    sign = side_of(run, e.vector[0]) < 0 ? -1 : 1;
    for (int k = 0; k < 3; k++)
        run->normal[k] = sign * e.vector[0][k];
    return true;
}

/* Least squares of the heights over the plane there is, z = a + b x + c y, turn plane and basis.
 * Where the points are too steep for that, all stays. */
static void tilt(struct dx_project_run *run, const struct dx_sym3 *m)
{
    double mu[3], mv[3], xx, xy, yy, xz, yz, det, b, c;

    times(mu, m, run->u);
    times(mv, m, run->v);
    xx = dot(mu, run->u);
    xy = dot(mu, run->v);
    xz = dot(mu, run->normal);
    yy = dot(mv, run->v);
    yz = dot(mv, run->normal);
    det = xx * yy - xy * xy;
    if (!(det > THIN * (xx + yy) * (xx + yy)))
        return;
    b = (xz * yy - yz * xy) / det;
    c = (yz * xx - xz * xy) / det;
    if (!(b * b + c * c < 3)) /* 60 degrees */
        return;
    for (int k = 0; k < 3; k++)
        run->normal[k] -= b * run->u[k] + c * run->v[k];
    normalise(run->normal);
    set_basis(run);
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

static void set_flat(struct dx_project_run *run)
{
    const double scale = DX_PROJECT_FLAT / run->radius;

    for (int k = 0; k < 3; k++) {
        run->flat_u[k] = scale * run->u[k];
        run->flat_v[k] = scale * run->v[k];
    }
}

bool dx_project_set_plane(struct dx_project_run *run)
{
    const struct dx_project_point *p = &run->point[run->r];
    const struct dx_sym3 m = moments(run);

    for (int k = 0; k < 3; k++)
        run->normal[k] = (double)p->normal[k];
    if ((!p->ring || !normalise(run->normal)) && !principal(run, &m))
        return false;
    set_basis(run);
    if (run->plane != DX_PROJECT_FACES)
        tilt(run, &m);
    if (run->plane == DX_PROJECT_AXIS)
        snap_to_axis(run);
    set_flat(run);
    return true;
}

/* To the nearest, halves to the even one: the last bits of a sum with so large a number are the
 * integer. */
static int32_t flat(double x)
{
    const double most = DX_FLAT_MAX / 2.0;
    uint64_t bits;

    x = x > most ? most : x;
    x = x < -most ? -most : x;
    x += 0x1.8p52;
    memcpy(&bits, &x, sizeof(bits));
    return (int32_t)(uint32_t)bits;
}

static struct dx_flat flat_at(const struct dx_project_run *run, double x, double y, double z)
{
    const double *u = run->flat_u, *v = run->flat_v;

    return (struct dx_flat){flat(u[0] * x + u[1] * y + u[2] * z),
                            flat(v[0] * x + v[1] * y + v[2] * z)};
}

struct dx_flat dx_project_flat(const struct dx_project_run *run, uint32_t rank)
{
    const int32_t *p = run->cloud->at[rank], *r = run->cloud->at[run->r];

    return flat_at(run, p[0] - r[0], p[1] - r[1], p[2] - r[2]);
}

struct dx_flat dx_project_flat_near(const struct dx_project_run *run, uint32_t k)
{
    return flat_at(run, run->offset[0][k], run->offset[1][k], run->offset[2][k]);
}
