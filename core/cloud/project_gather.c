/*
 * Pruning by distance (section 4.1): the box over dexels, then the sphere of influence. The paper's
 * radius, mu times the distance m of the nearest point, collapses where two points nearly meet; so
 * it is at least a share of the distance of the sixth nearest.
 */
#include "core/cloud/project_priv.h"

#include <math.h>

#define N_NEAREST  6
#define AT_LEAST   1.5 /* distances of the sixth nearest */
#define WIDEST     4   /* of them: to look farther is to guess */
#define MANY_STEPS 64

/* Squared distances of the nearest ones, ascending. */
static uint32_t nearest(int64_t d2[N_NEAREST], const struct dx_near *near, uint32_t n)
{
    uint32_t kept = 0;

    for (uint32_t k = 0; k < n; k++) {
        uint32_t j;

        if (kept == N_NEAREST && near[k].d2 >= d2[N_NEAREST - 1])
            continue;
        kept += kept < N_NEAREST;
        for (j = kept - 1; j > 0 && d2[j - 1] > near[k].d2; j--)
            d2[j] = d2[j - 1];
        d2[j] = near[k].d2;
    }
    return kept;
}

/* Points within the radius, without r; how many there are, which may be more than are stored. */
static uint32_t query(struct dx_project_run *run, double radius)
{
    const struct dx_cloud *c = run->cloud;
    const double far = 1u << 30;
    uint32_t n = dx_cloud_within(c, c->at[run->r], (int32_t)(radius < far ? radius : far),
                                 run->near, DX_PROJECT_MAX_NEAR);

    run->n_near = 0;
    if (n > DX_PROJECT_MAX_NEAR)
        return n;
    for (uint32_t k = 0; k < n; k++)
        if (run->near[k].rank != run->r)
            run->near[run->n_near++] = run->near[k];
    return run->n_near;
}

/* A radius with at least N_NEAREST points and not too many. */
static double find_radius(struct dx_project_run *run, double radius)
{
    uint32_t want = run->cloud->n - 1 < N_NEAREST ? run->cloud->n - 1 : N_NEAREST;
    double low = 0;

    for (int step = 0; step < MANY_STEPS; step++) {
        uint32_t n = query(run, radius);

        if (n > DX_PROJECT_MAX_NEAR) {
            radius = low > 0 ? (low + radius) / 2 : radius / 2;
        } else if (n < want) {
            low = radius;
            radius *= 1.5;
        } else {
            break;
        }
    }
    return radius;
}

static void drop_beyond(struct dx_project_run *run, double radius)
{
    const double r2 = radius * radius;
    uint32_t n = 0;

    for (uint32_t k = 0; k < run->n_near; k++)
        if ((double)run->near[k].d2 <= r2)
            run->near[n++] = run->near[k];
    run->n_near = n;
}

void dx_project_gather(struct dx_project_run *run, double factor)
{
    const double reach = (double)run->point[run->r].reach;
    double queried = reach > 0 ? 1.1 * reach : 1.1 * run->config->mu * run->spacing;
    int64_t d2[N_NEAREST] = {0};
    double dense, paper;
    uint32_t n;

    queried = find_radius(run, queried < 2 ? 2 : queried);
    n = nearest(d2, run->near, run->n_near);
    if (n == 0) {
        run->radius = run->widest = 0;
        return;
    }
    dense = sqrt((double)d2[n - 1]);
    paper = run->config->mu * sqrt((double)d2[0]);
    run->radius = paper > AT_LEAST * dense ? paper : AT_LEAST * dense;
    run->widest = run->radius > WIDEST * dense ? run->radius : WIDEST * dense;
    run->radius *= factor;
    run->radius = run->radius < run->widest ? run->radius : run->widest;
    if (run->max_edge > 0 && run->radius > run->max_edge)
        run->radius = run->widest = run->max_edge;
    if (run->radius > queried && query(run, run->radius) > DX_PROJECT_MAX_NEAR) {
        run->radius = queried;
        query(run, queried);
    }
    drop_beyond(run, run->radius);
}
