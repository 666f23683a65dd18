/* The tangent plane of a point, and other points turned into it. */
#include "core/cloud/delaunay_priv.h"

#include <math.h>

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* u and v, so that u, v, n are right-handed. */
static void set_basis(struct dx_tangent *t)
{
    const double *n = t->n;
    int least = fabs(n[0]) <= fabs(n[1]) ? 0 : 1, a, b;
    double len;

    least = fabs(n[2]) < fabs(n[least]) ? 2 : least;
    a = (least + 1) % 3;
    b = (least + 2) % 3;
    len = sqrt(n[a] * n[a] + n[b] * n[b]);
    t->u[least] = 0;
    t->u[a] = n[b] / len;
    t->u[b] = -n[a] / len;
    for (int k = 0; k < 3; k++)
        t->v[k] = n[(k + 1) % 3] * t->u[(k + 2) % 3] - n[(k + 2) % 3] * t->u[(k + 1) % 3];
}

static double distance(const int32_t a[3], const int32_t b[3])
{
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};

    return sqrt(dot(d, d));
}

bool dx_tangent_of(struct dx_tangent *t, const struct dx_delaunay_run *run, uint32_t rank)
{
    const float *n = run->normals[rank];
    const struct dx_neighbours *nb = run->nb;
    double reach;

    if (run->k == 0 || (n[0] == 0 && n[1] == 0 && n[2] == 0))
        return false;
    t->rank = rank;
    t->at = run->cloud->at[rank];
    for (int k = 0; k < 3; k++)
        t->n[k] = (double)n[k];
    set_basis(t);
    reach = distance(t->at, run->cloud->at[dx_neighbours_of(nb, rank)[run->k - 1]]);
    t->scale = DX_STAR_FLAT / reach;
    t->shadow = run->config->shadow;
    return true;
}
