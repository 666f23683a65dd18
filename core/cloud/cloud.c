/* Loading a cloud: bounds, lattice, dexels, duplicates. Pool tasks are runs of points or dexels,
 * each of which writes its own. */
#include "core/cloud/cloud.h"

#include "core/cloud/dexels.h"
#include "core/cloud/pages.h"

#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define RUN 16384 /* points of a task */

struct bounds {
    double low[3], high[3];
    uint32_t n_not_finite;
    bool too_far;
};

struct load {
    struct dx_cloud *cloud;
    const double *xyz;
    size_t n;
    struct bounds *bounds; /* of each run */
    struct dx_dexel_input input;
};

static uint32_t n_runs(size_t n)
{
    return (uint32_t)((n + RUN - 1) / RUN);
}

static bool is_finite(const double p[3])
{
    return isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]);
}

static void bound_run(void *ctx, uint32_t task, unsigned thread)
{
    struct load *l = ctx;
    struct bounds b = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}, 0, false};
    size_t end = (size_t)(task + 1) * RUN;

    (void)thread;
    for (size_t k = (size_t)task * RUN; k < end && k < l->n; k++) {
        const double *p = l->xyz + 3 * k;

        if (!is_finite(p)) {
            b.n_not_finite++;
            continue;
        }
        for (int i = 0; i < 3; i++) {
            b.low[i] = p[i] < b.low[i] ? p[i] : b.low[i];
            b.high[i] = p[i] > b.high[i] ? p[i] : b.high[i];
            b.too_far |= fabs(p[i]) > DX_CLOUD_MAX_ABS;
        }
    }
    l->bounds[task] = b;
}

static struct bounds bound_all(const struct load *l)
{
    struct bounds all = l->bounds[0];

    for (uint32_t k = 1; k < n_runs(l->n); k++) {
        const struct bounds *b = &l->bounds[k];

        for (int i = 0; i < 3; i++) {
            all.low[i] = b->low[i] < all.low[i] ? b->low[i] : all.low[i];
            all.high[i] = b->high[i] > all.high[i] ? b->high[i] : all.high[i];
        }
        all.n_not_finite += b->n_not_finite;
        all.too_far |= b->too_far;
    }
    return all;
}

/* The least power of two, so that steps are exact, with which `extent` fits the lattice. */
static double step_of(double extent)
{
    double step = 1;

    if (!(extent > 0))
        return 1;
    while (extent / step > DX_CLOUD_LATTICE)
        step *= 2;
    while (extent / (step / 2) <= DX_CLOUD_LATTICE)
        step /= 2;
    return step;
}

static void set_frame(struct dx_cloud *c, const struct bounds *b)
{
    double extent[3], largest = 0;
    int depth = 0;

    for (int k = 0; k < 3; k++) {
        extent[k] = b->high[k] - b->low[k];
        largest = extent[k] > largest ? extent[k] : largest;
        /* of equal extents, z */
        depth = extent[k] <= extent[depth] ? k : depth;
    }
    c->step = step_of(largest);
    for (int k = 0; k < 3; k++) {
        c->axis[k] = (depth + 1 + k) % 3;
        c->origin[k] = b->low[c->axis[k]];
    }
}

static void snap_run(void *ctx, uint32_t task, unsigned thread)
{
    struct load *l = ctx;
    const struct dx_cloud *c = l->cloud;
    size_t end = (size_t)(task + 1) * RUN;

    (void)thread;
    for (size_t k = (size_t)task * RUN; k < end && k < l->n; k++) {
        const double *p = l->xyz + 3 * k;
        int32_t *at = l->input.at[k];

        l->input.dexel[k] = is_finite(p) ? 0 : DX_DEXEL_NONE;
        if (l->input.dexel[k] == DX_DEXEL_NONE)
            continue;
        for (int i = 0; i < 3; i++)
            at[i] = (int32_t)rint((p[c->axis[i]] - c->origin[i]) / c->step);
    }
}

static void place_run(void *ctx, uint32_t task, unsigned thread)
{
    struct load *l = ctx;
    const struct dx_cloud *c = l->cloud;
    size_t end = (size_t)(task + 1) * RUN;

    (void)thread;
    for (size_t k = (size_t)task * RUN; k < end && k < l->n; k++) {
        const int32_t *at = l->input.at[k];

        if (l->input.dexel[k] != DX_DEXEL_NONE)
            l->input.dexel[k] = dx_dexel_place(c, 0, at[0]) * c->cols + dx_dexel_place(c, 1, at[1]);
    }
}

static int load(struct load *l, struct dx_pool *pool, struct dx_err *err)
{
    struct dx_cloud *c = l->cloud;
    struct bounds b;

    l->bounds = malloc(n_runs(l->n) * sizeof(*l->bounds));
    l->input.at = dx_pages_new(l->n * sizeof(*l->input.at));
    l->input.dexel = dx_pages_new(l->n * sizeof(*l->input.dexel));
    if (!l->bounds || !l->input.at || !l->input.dexel)
        return dx_err_set(err, -ENOMEM, "no memory for %zu points", l->n);
    dx_pool_run(pool, n_runs(l->n), bound_run, l);
    b = bound_all(l);
    if (b.too_far)
        return dx_err_set(err, -ERANGE, "a coordinate is beyond %g, expected less",
                          DX_CLOUD_MAX_ABS);
    c->n_not_finite = b.n_not_finite;
    c->n = (uint32_t)l->n - b.n_not_finite;
    if (c->n == 0)
        return 0;
    set_frame(c, &b);
    dx_pool_run(pool, n_runs(l->n), snap_run, l);
    l->input.n = (uint32_t)l->n;
    dx_dexels_size(c, &l->input);
    dx_pool_run(pool, n_runs(l->n), place_run, l);
    if (dx_dexels_fill(c, &l->input, pool) < 0)
        return dx_err_set(err, -ENOMEM, "no memory for %zu points", l->n);
    return 0;
}

int dx_cloud_init(struct dx_cloud *c, const double *xyz, size_t n, struct dx_pool *pool,
                  struct dx_err *err)
{
    struct load l = {.cloud = c, .xyz = xyz, .n = n};
    int rc;

    *c = (struct dx_cloud){.axis = {0, 1, 2}, .step = 1, .side = 1};
    if (n > DX_CLOUD_MAX_POINTS)
        return dx_err_set(err, -EFBIG, "%zu points, expected at most %zu", n, DX_CLOUD_MAX_POINTS);
    rc = n ? load(&l, pool, err) : 0;
    free(l.bounds);
    free(l.input.at);
    free(l.input.dexel);
    if (rc < 0)
        dx_cloud_fini(c);
    return rc;
}

void dx_cloud_fini(struct dx_cloud *c)
{
    free(c->at);
    free(c->index);
    free(c->start);
    *c = (struct dx_cloud){0};
}
