/* Dexels: a counting sort by dexel, each dexel by depth; what is the same point then is adjacent.
 */
#include "core/cloud/dexels.h"

#include "core/cloud/bulk.h"
#include "core/cloud/pages.h"

#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#define POINTS_A_DEXEL 8
#define DEXELS_A_TASK  4096
#define FEW            24 /* points that insertion sorts fastest */

void dx_dexels_size(struct dx_cloud *c, const struct dx_dexel_input *in)
{
    const int32_t(*at)[3] = (const int32_t(*)[3])in->at;
    const struct dx_bulk row = dx_bulk_find(at, in->dexel, in->n, 0),
                         col = dx_bulk_find(at, in->dexel, in->n, 1);
    const double row_extent = row.high - row.low, col_extent = col.high - col.low;
    double n_dexels = floor(c->n / (double)POINTS_A_DEXEL) + 1, longer, side;

    longer = row_extent > col_extent ? row_extent : col_extent;
    side = sqrt(row_extent * col_extent / n_dexels);
    /* a thin strip has one row of them */
    side = side > longer / n_dexels ? side : longer / n_dexels;
    side = floor(side) + 1;
    c->side = (int32_t)side;
    c->low[0] = row.low;
    c->low[1] = col.low;
    c->rows = (uint32_t)(row_extent / side) + 1;
    c->cols = (uint32_t)(col_extent / side) + 1;
}

/* Depth, then the other coordinates, then the number in the input: a total order. */
static bool is_before(const int32_t (*at)[3], uint32_t a, uint32_t b)
{
    for (int k = 2; k >= 0; k--)
        if (at[a][k] != at[b][k])
            return at[a][k] < at[b][k];
    return a < b;
}

static void sort_few(uint32_t *v, uint32_t n, const int32_t (*at)[3])
{
    for (uint32_t k = 1; k < n; k++) {
        uint32_t x = v[k], j = k;

        for (; j > 0 && is_before(at, x, v[j - 1]); j--)
            v[j] = v[j - 1];
        v[j] = x;
    }
}

static void sift(uint32_t *v, uint32_t k, uint32_t n, const int32_t (*at)[3])
{
    uint32_t x = v[k];

    for (uint32_t child; (child = 2 * k + 1) < n; k = child) {
        child += child + 1 < n && is_before(at, v[child], v[child + 1]);
        if (!is_before(at, x, v[child]))
            break;
        v[k] = v[child];
    }
    v[k] = x;
}

static void sort_many(uint32_t *v, uint32_t n, const int32_t (*at)[3])
{
    for (uint32_t k = n / 2; k-- > 0;)
        sift(v, k, n, at);
    for (uint32_t k = n; k-- > 1;) {
        uint32_t last = v[k];

        v[k] = v[0];
        v[0] = last;
        sift(v, 0, k, at);
    }
}

struct fill {
    struct dx_cloud *cloud;
    const struct dx_dexel_input *in;
    uint32_t *n_kept; /* of each task, without duplicates */
};

static uint32_t n_dexels(const struct dx_cloud *c)
{
    return c->rows * c->cols;
}

static bool is_same(const int32_t a[3], const int32_t b[3])
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

/* Sorts the dexels of a task; duplicates get the number DX_DEXEL_NONE. */
static void sort_dexels(void *ctx, uint32_t task, unsigned thread)
{
    const struct fill *f = ctx;
    const int32_t(*at)[3] = (const int32_t(*)[3])f->in->at;
    uint32_t first = task * DEXELS_A_TASK, end = first + DEXELS_A_TASK, kept = 0;

    (void)thread;
    for (uint32_t d = first; d < end && d < n_dexels(f->cloud); d++) {
        uint32_t *v = f->cloud->index + f->cloud->start[d];
        uint32_t n = f->cloud->start[d + 1] - f->cloud->start[d];
        uint32_t last = 0;

        if (n <= FEW)
            sort_few(v, n, at);
        else
            sort_many(v, n, at);
        for (uint32_t k = 1; k < n; k++) {
            if (is_same(at[v[k]], at[v[last]]))
                v[k] = DX_DEXEL_NONE;
            else
                last = k;
        }
        for (uint32_t k = 0; k < n; k++)
            kept += v[k] != DX_DEXEL_NONE;
    }
    f->n_kept[task] = kept;
}

static void close_gaps(struct dx_cloud *c)
{
    uint32_t to = 0, from = 0;

    for (uint32_t d = 0; d < n_dexels(c); d++) {
        for (; from < c->start[d + 1]; from++)
            if (c->index[from] != DX_DEXEL_NONE)
                c->index[to++] = c->index[from];
        c->start[d + 1] = to;
    }
    c->n_duplicates = c->n - to;
    c->n = to;
}

static void copy_points(void *ctx, uint32_t task, unsigned thread)
{
    const struct fill *f = ctx;
    const struct dx_cloud *c = f->cloud;
    uint32_t first = task * DEXELS_A_TASK, end = first + DEXELS_A_TASK;

    (void)thread;
    end = end < n_dexels(c) ? end : n_dexels(c);
    for (uint32_t r = c->start[first]; r < c->start[end]; r++)
        for (int k = 0; k < 3; k++)
            c->at[r][k] = f->in->at[c->index[r]][k];
}

/* start[d + 1] runs from the dexel's first place to its end. */
static void place(struct dx_cloud *c, const struct dx_dexel_input *in)
{
    uint32_t sum = 0;

    for (uint32_t k = 0; k < in->n; k++)
        if (in->dexel[k] != DX_DEXEL_NONE)
            c->start[in->dexel[k] + 1]++;
    for (uint32_t d = 0; d < n_dexels(c); d++) {
        uint32_t n = c->start[d + 1];

        c->start[d + 1] = sum;
        sum += n;
    }
    for (uint32_t k = 0; k < in->n; k++)
        if (in->dexel[k] != DX_DEXEL_NONE)
            c->index[c->start[in->dexel[k] + 1]++] = k;
}

int dx_dexels_fill(struct dx_cloud *c, const struct dx_dexel_input *in, struct dx_pool *pool)
{
    struct fill f = {.cloud = c, .in = in};
    uint32_t n_tasks = (n_dexels(c) + DEXELS_A_TASK - 1) / DEXELS_A_TASK, kept = 0;

    c->start = dx_pages_new_zeroed(((size_t)n_dexels(c) + 1) * sizeof(*c->start));
    c->index = dx_pages_new(c->n * sizeof(*c->index));
    c->at = dx_pages_new(c->n * sizeof(*c->at));
    f.n_kept = malloc(n_tasks * sizeof(*f.n_kept));
    if (!c->start || !c->index || !c->at || !f.n_kept) {
        free(f.n_kept);
        return -ENOMEM;
    }
    place(c, in);
    dx_pool_run(pool, n_tasks, sort_dexels, &f);
    for (uint32_t k = 0; k < n_tasks; k++)
        kept += f.n_kept[k];
    free(f.n_kept);
    if (kept < c->n)
        close_gaps(c);
    dx_pool_run(pool, n_tasks, copy_points, &f);
    return 0;
}
