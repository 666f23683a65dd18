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

/* Points within the radius, r among them; how many there are, which may be more than are stored. */
static uint32_t query(struct dx_project_run *run, double radius)
{
    const struct dx_cloud *c = run->cloud;

    return dx_cloud_within(c, c->at[run->r], (int32_t)radius, run->near, DX_PROJECT_MAX_NEAR);
}

/* A radius with at least MIN_NEAR points beside r and not too many. */
static double find_radius(struct dx_project_run *run, double radius)
{
    const uint32_t want = run->cloud->n < MIN_NEAR + 1 ? run->cloud->n : MIN_NEAR + 1;
    double low = 0;

    run->n_near = 0;
    for (int step = 0; step < MANY_STEPS; step++) {
        const uint32_t n = query(run, radius);

        run->n_near = n <= DX_PROJECT_MAX_NEAR ? n : 0;
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

/* Points within the radius, without r, and where they are from it. What is looked at next is on its
 * way while the plane is fitted. */
static void keep_within(struct dx_project_run *run, double radius)
{
    const int64_t r2 = (int64_t)(radius * radius);
    const int32_t *r = run->cloud->at[run->r];
    uint32_t n = 0;

    for (uint32_t k = 0; k < run->n_near; k++) {
        const struct dx_near p = run->near[k];
        const int32_t *at = run->cloud->at[p.rank];

        if (p.d2 > r2 || p.d2 == 0)
            continue;
        __builtin_prefetch(&run->state[p.rank]);
        __builtin_prefetch(&run->point[p.rank]);
        run->near[n] = p;
        for (int i = 0; i < 3; i++)
            run->offset[i][n] = at[i] - r[i];
        n++;
    }
    run->n_near = n;
}

static double nearest(const struct dx_project_run *run)
{
    uint64_t least = UINT64_MAX; /* less 1, so that r itself is far */

    for (uint32_t k = 0; k < run->n_near; k++) {
        const uint64_t d2 = (uint64_t)run->near[k].d2 - 1;

        least = d2 < least ? d2 : least;
    }
    return sqrt((double)(least + 1));
}

void dx_project_gather(struct dx_project_run *run, double factor)
{
    const double reach = (double)run->point[run->r].reach;
    double queried = ROOM * (reach > 0 ? factor * reach : run->config->mu * run->spacing);
    double dense, paper;

    queried = find_radius(run, queried < 2 ? 2 : queried > FAR ? FAR : queried);
    run->radius = run->widest = 0;
    if (run->n_near < 2) {
        run->n_near = 0;
        return;
    }
    dense = queried * sqrt(MIN_NEAR / (double)(run->n_near - 1));
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
    keep_within(run, run->radius);
}
