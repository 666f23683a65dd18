/*
 * Pruning by distance (section 4.1): the box over dexels, then the sphere of influence. The paper's
 * radius, mu times the distance m of the nearest point, collapses where two points nearly meet; so
 * it is at least a share of the radius that six points have where they are as dense as around r.
 */
#include "core/cloud/project_priv.h"

#include <math.h>

#define MIN_NEAR   6
#define ROOM       1.15 /* of the radius of who found r: so far is looked at first */
#define AT_LEAST   1.5  /* radii of MIN_NEAR points, where they are as dense as here */
#define WIDEST     4    /* of them: to look farther is to guess */
#define MANY_STEPS 64
#define FAR        (1 << 30) /* beyond the lattice */

/* Points within the radius, without r; how many there are, which may be more than are stored. */
static uint32_t query(struct dx_project_run *run, double radius)
{
    const struct dx_cloud *c = run->cloud;
    uint32_t n = dx_cloud_within(c, c->at[run->r], (int32_t)radius, run->near, DX_PROJECT_MAX_NEAR);

    run->n_near = 0;
    if (n > DX_PROJECT_MAX_NEAR)
        return n;
    for (uint32_t k = 0; k < n; k++)
        if (run->near[k].rank == run->r) {
            run->near[k] = run->near[--n];
            break;
        }
    run->n_near = n;
    return n;
}

/* A radius with at least MIN_NEAR points and not too many. */
static double find_radius(struct dx_project_run *run, double radius)
{
    uint32_t want = run->cloud->n - 1 < MIN_NEAR ? run->cloud->n - 1 : MIN_NEAR;
    double low = 0;

    for (int step = 0; step < MANY_STEPS; step++) {
        uint32_t n = query(run, radius);

        if (n > DX_PROJECT_MAX_NEAR) {
            radius = low > 0 ? (low + radius) / 2 : radius / 2;
        } else if (n < want) {
            low = radius;
            radius = radius < FAR / 1.5 ? 1.5 * radius : FAR;
        } else {
            break;
        }
    }
    return radius;
}

static void drop_beyond(struct dx_project_run *run, double radius)
{
    const int64_t r2 = (int64_t)(radius * radius);
    uint32_t n = 0;

    for (uint32_t k = 0; k < run->n_near; k++)
        if (run->near[k].d2 <= r2)
            run->near[n++] = run->near[k];
    run->n_near = n;
    for (uint32_t k = 0; k < n; k++) { /* on its way while the plane is fitted */
        __builtin_prefetch(&run->point[run->near[k].rank]);
        __builtin_prefetch(&run->state[run->near[k].rank]);
    }
}

static double nearest(const struct dx_project_run *run)
{
    int64_t least = run->near[0].d2;

    for (uint32_t k = 1; k < run->n_near; k++)
        least = run->near[k].d2 < least ? run->near[k].d2 : least;
    return sqrt((double)least);
}

void dx_project_gather(struct dx_project_run *run, double factor)
{
    const double reach = (double)run->point[run->r].reach;
    double queried = ROOM * (reach > 0 ? factor * reach : run->config->mu * run->spacing);
    double dense, paper;

    queried = find_radius(run, queried < 2 ? 2 : queried > FAR ? FAR : queried);
    run->radius = run->widest = 0;
    if (run->n_near == 0)
        return;
    dense = queried * sqrt(MIN_NEAR / (double)run->n_near);
    paper = run->config->mu * nearest(run);
    run->radius = paper > AT_LEAST * dense ? paper : AT_LEAST * dense;
    run->widest = run->radius > WIDEST * dense ? run->radius : WIDEST * dense;
    run->reach = run->radius;
    run->radius *= factor;
    run->radius = run->radius < run->widest ? run->radius : run->widest;
    if (run->max_edge > 0 && run->radius > run->max_edge)
        run->radius = run->widest = run->max_edge;
    if (run->radius > queried) /* nearly enough, or else it is widened */
        run->radius = queried;
    drop_beyond(run, run->radius);
}
