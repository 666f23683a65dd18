/* The tree level by level: the cells of a level are tasks, each of which orders its own members. */
#include "core/cloud/cluster.h"

#include "core/cloud/sym3.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

struct cell {
    uint32_t begin, end;
    uint32_t cut; /* where the second half begins; begin: it stays whole */
    bool whole;   /* for good */
};

struct tree {
    const struct dx_cloud *cloud;
    const struct dx_cluster_config *config;
    struct cell *cell, *next; /* in order of their members */
    uint32_t n, cap;
    uint32_t *todo; /* cells that are not whole */
    uint32_t n_todo;
    uint32_t *member, *scratch; /* [cloud->n] */
};

void dx_cluster_defaults(struct dx_cluster_config *config)
{
    *config = (struct dx_cluster_config){
        .split = DX_CLUSTER_ACROSS, .max_variation = 0.01, .min_points = 8, .max_points = 32};
}

static int check(const struct dx_cluster_config *c, struct dx_err *err)
{
    if (!(c->max_variation > 0 && c->max_variation <= 1))
        return dx_err_set(err, -EINVAL, "variation of a cluster is %g, expected above 0, to 1",
                          c->max_variation);
    if (c->min_points < 1)
        return dx_err_set(err, -EINVAL, "points of a cluster are %u, expected 1 or more",
                          c->min_points);
    if (c->max_points && c->max_points < c->min_points)
        return dx_err_set(err, -EINVAL, "points of a cluster are %u at most, expected %u or more",
                          c->max_points, c->min_points);
    return 0;
}

/* Sums of lattice coordinates are exact. */
static void set_centroid(double c[3], const struct tree *t, const struct cell *cell)
{
    int64_t sum[3] = {0};

    for (uint32_t k = cell->begin; k < cell->end; k++)
        for (int i = 0; i < 3; i++)
            sum[i] += t->cloud->at[t->member[k]][i];
    for (int i = 0; i < 3; i++)
        c[i] = (double)sum[i] / (cell->end - cell->begin);
}

static void set_axes(struct dx_eigen3 *e, const struct tree *t, const struct cell *cell,
                     const double c[3])
{
    struct dx_sym3 s = {{0}};

    for (uint32_t k = cell->begin; k < cell->end; k++) {
        const int32_t *p = t->cloud->at[t->member[k]];
        const double d[3] = {p[0] - c[0], p[1] - c[1], p[2] - c[2]};

        for (int i = 0, m = 0; i < 3; i++)
            for (int j = i; j < 3; j++, m++)
                s.m[m] += d[i] * d[j];
    }
    dx_sym3_eigen(e, &s);
}

/* Whether the cell is to be cut, by the plane through `c` with normal `axis`. */
static bool find_cut(double axis[3], double c[3], const struct tree *t, const struct cell *cell)
{
    const struct dx_cluster_config *config = t->config;
    const uint32_t n = cell->end - cell->begin;
    struct dx_eigen3 e;
    double sum;

    if (n <= config->min_points)
        return false;
    set_centroid(c, t, cell);
    set_axes(&e, t, cell, c);
    memcpy(axis, e.vector[config->split == DX_CLUSTER_ACROSS ? 2 : 0], 3 * sizeof(*axis));
    sum = e.value[0] + e.value[1] + e.value[2];
    return (config->max_points && n > config->max_points) ||
           e.value[0] > config->max_variation * sum;
}

/* Members below the plane first, each half in its order. */
static void cut_cell(void *ctx, uint32_t task, unsigned thread)
{
    const struct tree *t = ctx;
    struct cell *cell = &t->cell[t->todo[task]];
    double axis[3], c[3];
    uint32_t low = cell->begin, high = 0;

    (void)thread;
    cell->whole = true;
    if (!find_cut(axis, c, t, cell))
        return;
    for (uint32_t k = cell->begin; k < cell->end; k++) {
        const uint32_t r = t->member[k];
        const int32_t *p = t->cloud->at[r];

        if (axis[0] * (p[0] - c[0]) + axis[1] * (p[1] - c[1]) + axis[2] * (p[2] - c[2]) < 0)
            t->member[low++] = r;
        else
            t->scratch[cell->begin + high++] = r;
    }
    memcpy(t->member + low, t->scratch + cell->begin, high * sizeof(*t->member));
    cell->whole = low == cell->begin || low == cell->end;
    cell->cut = low;
}

static int reserve(struct tree *t, uint32_t n)
{
    if (n > t->cap) {
        const uint32_t cap = n + n / 2;
        struct cell *cell = realloc(t->cell, cap * sizeof(*cell)), *next;
        uint32_t *todo;

        if (!cell)
            return -ENOMEM;
        t->cell = cell;
        next = realloc(t->next, cap * sizeof(*next));
        if (!next)
            return -ENOMEM;
        t->next = next;
        todo = realloc(t->todo, cap * sizeof(*todo));
        if (!todo)
            return -ENOMEM;
        t->todo = todo;
        t->cap = cap;
    }
    return 0;
}

/* The next level: halves in the place of what was cut. */
static int descend(struct tree *t)
{
    struct cell *held;
    uint32_t n = 0;

    if (reserve(t, t->n + t->n_todo) < 0)
        return -ENOMEM;
    held = t->cell;
    t->n_todo = 0;
    for (uint32_t k = 0; k < t->n; k++) {
        const struct cell c = t->cell[k];

        if (c.whole) {
            t->next[n++] = c;
            continue;
        }
        for (int half = 0; half < 2; half++) {
            t->todo[t->n_todo++] = n;
            t->next[n++] = (struct cell){half ? c.cut : c.begin, half ? c.end : c.cut, 0, false};
        }
    }
    t->cell = t->next;
    t->next = held;
    t->n = n;
    return 0;
}

static int build(struct tree *t, struct dx_pool *pool)
{
    const uint32_t n = t->cloud->n;

    t->member = malloc(n * sizeof(*t->member));
    t->scratch = malloc(n * sizeof(*t->scratch));
    if (!t->member || !t->scratch || reserve(t, 1) < 0)
        return -ENOMEM;
    for (uint32_t k = 0; k < n; k++)
        t->member[k] = k;
    t->cell[0] = (struct cell){0, n, 0, false};
    t->todo[0] = 0;
    t->n = t->n_todo = 1;
    while (t->n_todo) {
        dx_pool_run(pool, t->n_todo, cut_cell, t);
        if (descend(t) < 0)
            return -ENOMEM;
    }
    return 0;
}

static int keep(struct dx_clusters *c, struct tree *t)
{
    c->start = malloc(((size_t)t->n + 1) * sizeof(*c->start));
    if (!c->start)
        return -ENOMEM;
    for (uint32_t k = 0; k < t->n; k++)
        c->start[k] = t->cell[k].begin;
    c->start[t->n] = t->cloud->n;
    c->n = t->n;
    c->member = t->member;
    t->member = NULL;
    return 0;
}

int dx_clusters_init(struct dx_clusters *c, const struct dx_cloud *cloud,
                     const struct dx_cluster_config *config, struct dx_pool *pool,
                     struct dx_err *err)
{
    struct tree t = {.cloud = cloud, .config = config};
    int rc = check(config, err);

    *c = (struct dx_clusters){0};
    if (rc < 0 || cloud->n == 0)
        return rc;
    rc = build(&t, pool);
    if (rc == 0)
        rc = keep(c, &t);
    if (rc < 0)
        dx_err_set(err, rc, "no memory for the clusters of %u points", cloud->n);
    free(t.cell);
    free(t.next);
    free(t.todo);
    free(t.member);
    free(t.scratch);
    return rc;
}

void dx_clusters_fini(struct dx_clusters *c)
{
    free(c->start);
    free(c->member);
    *c = (struct dx_clusters){0};
}
