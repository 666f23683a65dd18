/* Q over a cloud: neighbourhoods, runs of ranks over the pool. */
#include "core/cloud/smooth_cloud.h"

#include "core/cloud/smooth_fit.h"

#include <math.h>
#include <stdlib.h>

#define REACH     3.0 /* widths of the neighbourhood: w is 1.1 % there */
#define MIN_NEAR  12  /* points; where there are fewer, the width grows */
#define WIDEN     1.5
#define NARROW    0.75
#define MAX_TRIES 6
#define ROUGH     1e-2 /* convergence of a plane that a paraboloid follows */
#define CREASED   0.75 /* share of weights on a plane: noise alone leaves 0.9 */
#define CREASE_SW 0.65
#define RUN       512 /* points of a task */

/* The neighbourhood of a place, its unit and the widths that its density calls for. */
struct vicinity {
    struct dx_robust_points points;
    struct dx_near near[DX_ROBUST_MAX_POINTS];
    double factor; /* of the widths */
};

static void gather(struct vicinity *v, const struct dx_cloud *c,
                   const struct dx_cloud_smooth_scale *s, const double at[3])
{
    const int32_t p[3] = {(int32_t)rint(at[0]), (int32_t)rint(at[1]), (int32_t)rint(at[2])};
    uint32_t n = 0;

    v->factor = 1;
    for (int try = 0; try < MAX_TRIES; try++) {
        const double radius = REACH * s->sw * s->spacing * v->factor;

        n = dx_cloud_within(c, p, radius < DX_CLOUD_LATTICE ? (int32_t)radius : DX_CLOUD_LATTICE,
                            v->near, DX_ROBUST_MAX_POINTS);
        if (n >= MIN_NEAR && n <= DX_ROBUST_MAX_POINTS)
            break;
        v->factor *= n < MIN_NEAR ? WIDEN : NARROW;
    }
    v->points.n = n < DX_ROBUST_MAX_POINTS ? n : DX_ROBUST_MAX_POINTS;
    for (uint32_t k = 0; k < v->points.n; k++) {
        const int32_t *q = c->at[v->near[k].rank];

        v->points.x[k] = (q[0] - at[0]) / s->spacing;
        v->points.y[k] = (q[1] - at[1]) / s->spacing;
        v->points.z[k] = (q[2] - at[2]) / s->spacing;
    }
}

struct tally {
    uint32_t n_unchanged, n_planes;
    uint64_t n_steps, n_near;
    double moved2;
};

/* The plane, and how far to move along its normal. */
static int fit(struct dx_robust_plane *plane, double *move, struct vicinity *v, struct tally *tally,
               const struct dx_cloud_smooth_scale *s, double sw)
{
    struct dx_robust_quadric q;
    uint32_t n_steps;
    int rc;

    dx_robust_weigh(&v->points, sw);
    rc = dx_robust_plane(plane, &n_steps, &v->points, sw, s->sr,
                         s->quadric ? ROUGH : DX_ROBUST_SETTLED);
    tally->n_steps += n_steps;
    if (rc == DX_ROBUST_NONE)
        return rc;
    *move = plane->t;
    if (s->quadric && dx_robust_quadric(&q, &v->points, plane, s->sr))
        *move = q.term[0];
    else
        tally->n_planes += s->quadric;
    return DX_ROBUST_DONE;
}

/* Once more where much of what is near is off the plane, at a crease: with a narrower width, and
 * always with a paraboloid. */
static int project(struct dx_cloud_smoothed *out, struct vicinity *v, struct tally *tally,
                   const struct dx_cloud *c, const struct dx_cloud_smooth_scale *s,
                   const double at[3])
{
    struct dx_robust_plane plane, narrow;
    struct dx_cloud_smooth_scale creased = *s;
    double move, narrow_move, sw;

    for (int k = 0; k < 3; k++) {
        out->at[k] = at[k];
        out->normal[k] = 0;
    }
    creased.quadric = true;
    gather(v, c, s, at);
    sw = s->sw * v->factor;
    tally->n_near += v->points.n;
    if (fit(&plane, &move, v, tally, s, sw) == DX_ROBUST_NONE) {
        tally->n_unchanged++;
        return DX_CLOUD_SMOOTH_UNCHANGED;
    }
    if (plane.share < CREASED &&
        fit(&narrow, &narrow_move, v, tally, &creased, CREASE_SW * sw) == DX_ROBUST_DONE) {
        plane = narrow;
        move = narrow_move;
    }
    for (int k = 0; k < 3; k++) {
        out->at[k] = at[k] + move * s->spacing * plane.normal[k];
        out->normal[k] = (float)plane.normal[k];
    }
    tally->moved2 += move * move;
    return DX_CLOUD_SMOOTH_DONE;
}

struct job {
    const struct dx_cloud *cloud;
    const struct dx_cloud_smooth_scale *scale;
    struct dx_cloud_smoothed *out;
    struct tally *tally; /* of each task */
};

static void smooth_run(void *ctx, uint32_t task, unsigned thread)
{
    const struct job *j = ctx;
    const uint32_t first = task * RUN, end = first + RUN;
    struct tally tally = {0};
    struct vicinity v;

    (void)thread;
    for (uint32_t r = first; r < end && r < j->cloud->n; r++) {
        const int32_t *p = j->cloud->at[r];

        project(&j->out[r], &v, &tally, j->cloud, j->scale, (double[3]){p[0], p[1], p[2]});
    }
    if (j->tally)
        j->tally[task] = tally;
}

void dx_cloud_smooth(struct dx_cloud_smoothed *out, struct dx_cloud_smooth_stats *stats,
                     const struct dx_cloud *c, const struct dx_cloud_smooth_scale *scale,
                     struct dx_pool *pool)
{
    const uint32_t n_tasks = (c->n + RUN - 1) / RUN;
    struct job j = {c, scale, out, NULL};
    struct tally sum = {0};

    *stats = (struct dx_cloud_smooth_stats){0};
    if (c->n == 0)
        return;
    j.tally = malloc(n_tasks * sizeof(*j.tally)); /* without it there are no statistics */
    dx_pool_run(pool, n_tasks, smooth_run, &j);
    for (uint32_t k = 0; j.tally && k < n_tasks; k++) {
        sum.n_unchanged += j.tally[k].n_unchanged;
        sum.n_planes += j.tally[k].n_planes;
        sum.n_steps += j.tally[k].n_steps;
        sum.n_near += j.tally[k].n_near;
        sum.moved2 += j.tally[k].moved2;
    }
    free(j.tally);
    *stats = (struct dx_cloud_smooth_stats){
        .n_unchanged = sum.n_unchanged,
        .n_planes = sum.n_planes,
        .mean_steps = (double)sum.n_steps / c->n,
        .mean_near = (double)sum.n_near / c->n,
        .rms_moved = scale->spacing * sqrt(sum.moved2 / c->n),
    };
}

int dx_cloud_smooth_place(struct dx_cloud_smoothed *out, const struct dx_cloud *c,
                          const struct dx_cloud_smooth_scale *scale, const double at[3])
{
    struct tally tally = {0};
    struct vicinity v;

    return project(out, &v, &tally, c, scale, at);
}

void dx_cloud_to_input(double xyz[3], const struct dx_cloud *c, const double at[3])
{
    for (int k = 0; k < 3; k++)
        xyz[c->axis[k]] = c->origin[k] + c->step * at[k];
}
