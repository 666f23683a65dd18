/* Loading a cloud: bounds, lattice, dexels, duplicates. Pool tasks are runs of points or dexels,
 * each of which writes its own. */
#include "core/cloud/cloud.h"

#include "core/cloud/bulk.h"
#include "core/cloud/dexels.h"
#include "core/cloud/pages.h"

#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define RUN        16384 /* points of a task */
#define FINE       16    /* steps between neighbours of a surface, at least */
#define MAX_PASSES 32    /* of leaving out strays: they may have strays of their own */

struct bounds {
    double low[3], high[3];
    uint32_t n_not_finite, n_strays;
    bool too_far;
};

struct load {
    struct dx_cloud *cloud;
    const double *xyz;
    size_t n;
    struct bounds *bounds;  /* of each run */
    double low[3], high[3]; /* beyond them are strays */
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

static bool is_stray(const struct load *l, const double p[3])
{
    bool is = false;

    for (int i = 0; i < 3; i++)
        is |= p[i] < l->low[i] || p[i] > l->high[i];
    return is;
}

static void bound_run(void *ctx, uint32_t task, unsigned thread)
{
    struct load *l = ctx;
    struct bounds b = {
        {INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}, 0, 0, false};
    size_t end = (size_t)(task + 1) * RUN;

    (void)thread;
    for (size_t k = (size_t)task * RUN; k < end && k < l->n; k++) {
        const double *p = l->xyz + 3 * k;

        if (!is_finite(p)) {
            b.n_not_finite++;
            continue;
        }
        if (is_stray(l, p)) {
            b.n_strays++;
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
        all.n_strays += b->n_strays;
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

        l->input.dexel[k] = is_finite(p) && !is_stray(l, p) ? 0 : DX_DEXEL_NONE;
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

/* One lattice for all the points. */
static int snap(struct load *l, struct dx_pool *pool, struct dx_err *err)
{
    struct dx_cloud *c = l->cloud;
    struct bounds b;

    dx_pool_run(pool, n_runs(l->n), bound_run, l);
    b = bound_all(l);
    if (b.too_far)
        return dx_err_set(err, -ERANGE, "a coordinate is beyond %g, expected less",
                          DX_CLOUD_MAX_ABS);
    c->n_not_finite = b.n_not_finite;
    c->n_strays = b.n_strays;
    c->n = (uint32_t)l->n - b.n_not_finite - b.n_strays;
    if (c->n == 0)
        return 0;
    set_frame(c, &b);
    dx_pool_run(pool, n_runs(l->n), snap_run, l);
    return 0;
}

/*
 * Where a few points are so far that the others would be on neighbouring steps of the lattice, or
 * on one, those few are left out. True: there are such. They are beyond a box around most of the
 * points that, on a lattice of its own, leaves these four times as many steps as they need.
 */
static bool leave_out_strays(struct load *l)
{
    const struct dx_cloud *c = l->cloud;
    const double need = FINE * sqrt((double)c->n);
    const double room = DX_CLOUD_LATTICE / (8 * need); /* boxes of most points, to each side */
    struct dx_bulk most[3];
    double extent = 0;

    for (int k = 0; k < 3; k++) {
        most[k] = dx_bulk_find(l->input.at, l->input.dexel, (uint32_t)l->n, k);
        extent = fmax(extent, (double)most[k].high - most[k].low);
    }
    if (extent >= need)
        return false;
    for (int k = 0; k < 3; k++) {
        const double beyond = room * (extent + 1);

        l->low[c->axis[k]] = c->origin[k] + c->step * (most[k].low - beyond);
        l->high[c->axis[k]] = c->origin[k] + c->step * (most[k].high + beyond);
    }
    return true;
}

static int load(struct load *l, struct dx_pool *pool, struct dx_err *err)
{
    struct dx_cloud *c = l->cloud;
    int rc;

    l->bounds = malloc(n_runs(l->n) * sizeof(*l->bounds));
    l->input.n = (uint32_t)l->n;
    l->input.at = dx_pages_new(l->n * sizeof(*l->input.at));
    l->input.dexel = dx_pages_new(l->n * sizeof(*l->input.dexel));
    if (!l->bounds || !l->input.at || !l->input.dexel)
        return dx_err_set(err, -ENOMEM, "no memory for %zu points", l->n);
    rc = snap(l, pool, err);
    for (int pass = 0; rc == 0 && c->n > 1 && pass < MAX_PASSES && leave_out_strays(l); pass++) {
        const uint32_t before = c->n_strays;

        rc = snap(l, pool, err);
        if (c->n_strays == before)
            break;
    }
    if (rc < 0 || c->n == 0)
        return rc;
    dx_dexels_size(c, &l->input);
    dx_pool_run(pool, n_runs(l->n), place_run, l);
    if (dx_dexels_fill(c, &l->input, pool) < 0)
        return dx_err_set(err, -ENOMEM, "no memory for %zu points", l->n);
    return 0;
}

int dx_cloud_init(struct dx_cloud *c, const double *xyz, size_t n, struct dx_pool *pool,
                  struct dx_err *err)
{
    struct load l = {.cloud = c,
                     .xyz = xyz,
                     .n = n,
                     .low = {-INFINITY, -INFINITY, -INFINITY},
                     .high = {INFINITY, INFINITY, INFINITY}};
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
