/* Representatives of clusters, over the pool; then those that nearly meet are made one. */
#include "core/cloud/reduce.h"

#include "core/cloud/cloud_normals.h"
#include "core/cloud/spacing.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>

#define RUN      64  /* clusters of a task */
#define MAX_MOVE 2.0 /* widths of Q from the centroid */
#define MEETING  0.3 /* of the median distance of neighbours: one of both is enough */
#define MAX_NEAR 64

struct job {
    const struct dx_cloud *cloud;
    const struct dx_clusters *clusters;
    const struct dx_cloud_smooth_scale *scale;
    struct dx_cloud_smoothed *of; /* [clusters->n] */
    bool *is_medoid;
};

static double distance2(const double a[3], const double b[3])
{
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};

    return d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
}

static void set_centroid(double c[3], const struct job *j, uint32_t k)
{
    const uint32_t *start = j->clusters->start;
    int64_t sum[3] = {0};

    for (uint32_t i = start[k]; i < start[k + 1]; i++)
        for (int a = 0; a < 3; a++)
            sum[a] += j->cloud->at[j->clusters->member[i]][a];
    for (int a = 0; a < 3; a++)
        c[a] = (double)sum[a] / (start[k + 1] - start[k]);
}

/* The member next to the centroid. */
static void take_medoid(struct dx_cloud_smoothed *out, const struct job *j, uint32_t k,
                        const double centroid[3])
{
    const uint32_t *start = j->clusters->start;
    double least = INFINITY;

    for (uint32_t i = start[k]; i < start[k + 1]; i++) {
        const int32_t *p = j->cloud->at[j->clusters->member[i]];
        const double at[3] = {p[0], p[1], p[2]}, d2 = distance2(at, centroid);

        if (d2 >= least)
            continue;
        least = d2;
        for (int a = 0; a < 3; a++)
            out->at[a] = at[a];
    }
}

static void represent_run(void *ctx, uint32_t task, unsigned thread)
{
    const struct job *j = ctx;
    const double limit = MAX_MOVE * j->scale->sw * j->scale->spacing;
    const uint32_t first = task * RUN, end = first + RUN;

    (void)thread;
    for (uint32_t k = first; k < end && k < j->clusters->n; k++) {
        double c[3];
        int rc;

        set_centroid(c, j, k);
        rc = dx_cloud_smooth_place(&j->of[k], j->cloud, j->scale, c);
        j->is_medoid[k] =
            rc == DX_CLOUD_SMOOTH_UNCHANGED || distance2(j->of[k].at, c) > limit * limit;
        if (j->is_medoid[k])
            take_medoid(&j->of[k], j, k, c);
    }
}

/* Drops, by clearing keep[], what is next to a point of lower rank that stays. */
static int mark_meeting(bool *keep, const struct dx_reduced *r, struct dx_pool *pool,
                        struct dx_err *err)
{
    struct dx_near near[MAX_NEAR];
    struct dx_cloud c;
    int32_t radius;
    int rc = dx_cloud_init(&c, r->xyz[0], r->n, pool, err);

    if (rc < 0)
        return rc;
    radius = (int32_t)(MEETING * dx_cloud_spacing(&c));
    for (uint32_t k = 0; k < r->n; k++)
        keep[k] = false;
    for (uint32_t k = 0; k < c.n; k++)
        keep[c.index[k]] = true;
    for (uint32_t k = 0; k < c.n; k++) {
        uint32_t n;

        if (!keep[c.index[k]])
            continue;
        n = dx_cloud_within(&c, c.at[k], radius, near, MAX_NEAR);
        for (uint32_t i = 0; i < n && i < MAX_NEAR; i++)
            if (near[i].rank > k)
                keep[c.index[near[i].rank]] = false;
    }
    dx_cloud_fini(&c);
    return 0;
}

static int merge(struct dx_reduced *r, struct dx_pool *pool, struct dx_err *err)
{
    bool *keep = malloc(r->n * sizeof(*keep));
    uint32_t n = 0;
    int rc = keep ? mark_meeting(keep, r, pool, err)
                  : dx_err_set(err, -ENOMEM, "no memory for %u points", r->n);

    for (uint32_t k = 0; rc == 0 && k < r->n; k++) {
        if (!keep[k])
            continue;
        for (int i = 0; i < 3; i++) {
            r->xyz[n][i] = r->xyz[k][i];
            r->normal[n][i] = r->normal[k][i];
        }
        n++;
    }
    r->n_merged = r->n - n;
    r->n = n;
    free(keep);
    return rc;
}

static int represent(struct dx_reduced *out, struct job *j, struct dx_pool *pool,
                     struct dx_err *err)
{
    const uint32_t n = j->clusters->n;

    j->of = malloc(n * sizeof(*j->of));
    j->is_medoid = malloc(n * sizeof(*j->is_medoid));
    out->xyz = malloc(n * sizeof(*out->xyz));
    out->normal = malloc(n * sizeof(*out->normal));
    if (!j->of || !j->is_medoid || !out->xyz || !out->normal)
        return dx_err_set(err, -ENOMEM, "no memory for %u points", n);
    dx_pool_run(pool, (n + RUN - 1) / RUN, represent_run, j);
    out->n = n;
    for (uint32_t k = 0; k < n; k++) {
        dx_cloud_to_input(out->xyz[k], j->cloud, j->of[k].at);
        dx_cloud_normal_out(out->normal[k], j->cloud, j->of[k].normal);
        out->n_medoids += j->is_medoid[k];
    }
    return merge(out, pool, err);
}

int dx_reduce(struct dx_reduced *out, const struct dx_cloud *cloud,
              const struct dx_clusters *clusters, const struct dx_cloud_smooth_scale *scale,
              struct dx_pool *pool, struct dx_err *err)
{
    struct job j = {.cloud = cloud, .clusters = clusters, .scale = scale};
    int rc;

    *out = (struct dx_reduced){0};
    if (clusters->n == 0)
        return 0;
    rc = represent(out, &j, pool, err);
    free(j.of);
    free(j.is_medoid);
    if (rc < 0)
        dx_reduced_fini(out);
    return rc;
}

void dx_reduced_fini(struct dx_reduced *r)
{
    free(r->xyz);
    free(r->normal);
    *r = (struct dx_reduced){0};
}
