/*
 * Fans are sets of corners: of the same vertex, joined by common edges. Loops are sets of fans,
 * joined by boundary edges; so loops that touch in a vertex of two fans stay two.
 */
#include "tools/mesh_topology.h"

#include "tools/union_find.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* The edge from a corner to the next one of its triangle. */
struct edge {
    uint32_t high;   /* of its vertices */
    uint32_t corner; /* 3 t + k */
};

struct work {
    const struct dx_mesh *mesh;
    uint32_t n;        /* corners */
    uint32_t *end;     /* [n_vertices + 1] of the edges under their lower vertex */
    struct edge *edge; /* [n] */
    uint32_t *fan;     /* [n] union-find */
    uint32_t *loop;    /* [n] the same, of the fans' roots */
    uint32_t *count;   /* [n] edges of a loop; [n_vertices] fans of a vertex */
};

static uint32_t next_of(uint32_t corner)
{
    return corner % 3 == 2 ? corner - 2 : corner + 1;
}

static uint32_t low_of(const struct work *w, uint32_t corner)
{
    const uint32_t a = w->mesh->index[corner], b = w->mesh->index[next_of(corner)];

    return a < b ? a : b;
}

static int compare_edges(const void *a, const void *b)
{
    const struct edge *x = a, *y = b;

    return x->high != y->high ? (x->high > y->high) - (x->high < y->high)
                              : (x->corner > y->corner) - (x->corner < y->corner);
}

/* By counting under the lower vertex, then each small bucket by the higher one. */
static void sort_edges(struct work *w)
{
    const uint32_t n_vertices = w->mesh->n_vertices;
    uint32_t sum = 0;

    for (uint32_t c = 0; c < w->n; c++)
        w->end[low_of(w, c)]++;
    for (uint32_t v = 0; v < n_vertices; v++) {
        const uint32_t size = w->end[v];

        w->end[v] = sum;
        sum += size;
    }
    for (uint32_t c = 0; c < w->n; c++) {
        const uint32_t a = w->mesh->index[c], b = w->mesh->index[next_of(c)];

        w->edge[w->end[a < b ? a : b]++] = (struct edge){a < b ? b : a, c};
    }
    for (uint32_t v = 0, start = 0; v < n_vertices; start = w->end[v++])
        if (w->end[v] - start > 1)
            qsort(w->edge + start, w->end[v] - start, sizeof(*w->edge), compare_edges);
}

/* The corner of a triangle's edge that is at vertex v. */
static uint32_t corner_at(const struct work *w, uint32_t corner, uint32_t v)
{
    return w->mesh->index[corner] == v ? corner : next_of(corner);
}

/* Calls `visit` with each run of triangles at one edge. */
static void for_each_edge(struct work *w, void (*visit)(struct work *w, uint32_t low,
                                                        const struct edge *edge, uint32_t n))
{
    for (uint32_t v = 0, start = 0; v < w->mesh->n_vertices; start = w->end[v++])
        for (uint32_t i = start, j; i < w->end[v]; i = j) {
            for (j = i + 1; j < w->end[v] && w->edge[j].high == w->edge[i].high;)
                j++;
            visit(w, v, w->edge + i, j - i);
        }
}

static void join_fans(struct work *w, uint32_t low, const struct edge *edge, uint32_t n)
{
    const uint32_t v[2] = {low, edge->high};

    for (uint32_t i = 1; i < n; i++)
        for (int k = 0; k < 2; k++)
            dx_union_join(w->fan, corner_at(w, edge[0].corner, v[k]),
                          corner_at(w, edge[i].corner, v[k]));
}

static void join_loops(struct work *w, uint32_t low, const struct edge *edge, uint32_t n)
{
    (void)low;
    if (n == 1)
        dx_union_join(w->loop, dx_union_root(w->fan, edge->corner),
                      dx_union_root(w->fan, next_of(edge->corner)));
}

static void count_loops(struct work *w, uint32_t low, const struct edge *edge, uint32_t n)
{
    (void)low;
    if (n == 1)
        w->count[dx_union_root(w->loop, dx_union_root(w->fan, edge->corner))]++;
}

static void count(struct dx_mesh_topology *t, struct work *w)
{
    sort_edges(w);
    for (uint32_t c = 0; c < w->n; c++)
        w->fan[c] = w->loop[c] = c;
    for_each_edge(w, join_fans);
    for (uint32_t c = 0; c < w->n; c++)
        if (w->fan[c] == c)
            t->nonmanifold_vertices += ++w->count[w->mesh->index[c]] == 2;
    memset(w->count, 0, ((size_t)w->mesh->n_vertices + w->n) * sizeof(*w->count));
    for_each_edge(w, join_loops);
    for_each_edge(w, count_loops);
    for (uint32_t c = 0; c < w->n; c++) {
        t->boundary_loops += w->count[c] > 0;
        if (w->count[c] > t->longest_loop)
            t->longest_loop = w->count[c];
    }
}

int dx_mesh_topology_compute(struct dx_mesh_topology *t, const struct dx_mesh *mesh)
{
    const size_t n = 3 * (size_t)mesh->n_triangles;
    struct work w = {.mesh = mesh, .n = (uint32_t)n};
    int rc = 0;

    *t = (struct dx_mesh_topology){0};
    if (n > UINT32_MAX)
        return -EOVERFLOW;
    w.end = calloc((size_t)mesh->n_vertices + 1, sizeof(*w.end));
    w.edge = malloc(n * sizeof(*w.edge) + 1);
    w.fan = malloc(n * sizeof(*w.fan) + 1);
    w.loop = malloc(n * sizeof(*w.loop) + 1);
    w.count = calloc(n + mesh->n_vertices + 1, sizeof(*w.count));
    if (w.end && w.edge && w.fan && w.loop && w.count)
        count(t, &w);
    else
        rc = -ENOMEM;
    free(w.end);
    free(w.edge);
    free(w.fan);
    free(w.loop);
    free(w.count);
    return rc;
}
