/* Fitted planes, over the pool; then their sides. */
#include "core/cloud/cloud_normals.h"

#include "core/cloud/least_axis.h"
#include "core/cloud/orient.h"

#include <errno.h>
#include <string.h>

#define RUN 1024 /* points of a task */

struct fit {
    float (*n)[3];
    float *variation;
    const struct dx_cloud *cloud;
    const struct dx_neighbours *nb;
    uint32_t k;
};

void dx_cloud_normals_defaults(struct dx_cloud_normals_config *config)
{
    *config = (struct dx_cloud_normals_config){.k = 16};
}

/* Of a point and k neighbours, about their mean, times their number. */
static void covariance(struct dx_sym3 *s, const struct fit *f, uint32_t rank)
{
    const uint32_t *near = dx_neighbours_of(f->nb, rank);
    const int32_t *p = f->cloud->at[rank];
    double sum[3] = {0};

    *s = (struct dx_sym3){{0}};
    for (uint32_t k = 0; k < f->k; k++) {
        const int32_t *q = f->cloud->at[near[k]];
        const double x = q[0] - p[0], y = q[1] - p[1], z = q[2] - p[2];

        sum[0] += x;
        sum[1] += y;
        sum[2] += z;
        s->m[0] += x * x;
        s->m[1] += x * y;
        s->m[2] += x * z;
        s->m[3] += y * y;
        s->m[4] += y * z;
        s->m[5] += z * z;
    }
    for (int i = 0, m = 0; i < 3; i++)
        for (int j = i; j < 3; j++, m++)
            s->m[m] -= sum[i] * sum[j] / (f->k + 1);
}

static void fit_run(void *ctx, uint32_t task, unsigned thread)
{
    const struct fit *f = ctx;
    const uint32_t first = task * RUN, n = f->cloud->n;
    const uint32_t end = n - first < RUN ? n : first + RUN;

    (void)thread;
    for (uint32_t r = first; r < end; r++) {
        struct dx_sym3 s;
        double axis[3] = {0}, share = 0;

        covariance(&s, f, r);
        if (f->k < 2 || !dx_least_axis(axis, &share, &s))
            axis[0] = axis[1] = axis[2] = 0;
        for (int k = 0; k < 3; k++)
            f->n[r][k] = (float)axis[k];
        if (f->variation)
            f->variation[r] = (float)share;
    }
}

static uint32_t count_undefined(const float (*n)[3], uint32_t n_points)
{
    uint32_t sum = 0;

    for (uint32_t r = 0; r < n_points; r++)
        sum += n[r][0] == 0 && n[r][1] == 0 && n[r][2] == 0;
    return sum;
}

static int fit_and_orient(struct dx_cloud_normals_stats *stats, const struct fit *f,
                          const double *viewpoint, struct dx_pool *pool, struct dx_err *err)
{
    const uint32_t n = f->cloud->n;
    int rc;

    dx_pool_run(pool, (n + RUN - 1) / RUN, fit_run, (void *)f);
    stats->n_undefined = count_undefined((const float(*)[3])f->n, n);
    rc = dx_orient(f->n, &stats->n_parts, f->cloud, f->nb, f->k, viewpoint, pool);
    if (rc < 0)
        dx_err_set(err, rc, "no memory for the normals of %u points", n);
    return rc;
}

int dx_cloud_normals(float (*n)[3], float *variation, struct dx_cloud_normals_stats *stats,
                     const struct dx_cloud *cloud, const struct dx_neighbours *nb,
                     const struct dx_cloud_normals_config *config, struct dx_pool *pool,
                     struct dx_err *err)
{
    struct fit f = {n, variation, cloud, nb, config->k};
    struct dx_neighbours own = {0};
    int rc = 0;

    *stats = (struct dx_cloud_normals_stats){0};
    if (config->k < 2 || config->k > DX_CLOUD_MAX_NEAREST)
        return dx_err_set(err, -EINVAL, "%u neighbours for a normal, expected 2 to %d", config->k,
                          DX_CLOUD_MAX_NEAREST);
    if (cloud->n == 0)
        return 0;
    if (!nb) {
        rc = dx_neighbours_init(&own, cloud, config->k, pool, err);
        f.nb = &own;
    }
    f.k = f.k < f.nb->k ? f.k : f.nb->k;
    if (rc == 0)
        rc = fit_and_orient(stats, &f, config->viewpoint, pool, err);
    dx_neighbours_fini(&own);
    return rc;
}
