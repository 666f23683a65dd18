/* Counting sort under the lower vertex, then each small bucket by the higher one. */
#include "tools/mesh_edges.h"

#include <errno.h>
#include <stdlib.h>

#define SMALL 32 /* edges under a vertex: more are not from a surface's usual vertex */

static int compare_edges(const void *a, const void *b)
{
    const struct dx_mesh_edge *x = a, *y = b;

    return x->high != y->high ? (x->high > y->high) - (x->high < y->high)
                              : (x->corner > y->corner) - (x->corner < y->corner);
}

static void sort_bucket(struct dx_mesh_edge *edge, uint32_t n)
{
    if (n > SMALL) {
        qsort(edge, n, sizeof(*edge), compare_edges);
        return;
    }
    for (uint32_t i = 1; i < n; i++) {
        const struct dx_mesh_edge key = edge[i];
        uint32_t j = i;

        for (; j > 0 && compare_edges(&edge[j - 1], &key) > 0; j--)
            edge[j] = edge[j - 1];
        edge[j] = key;
    }
}

static void sort_edges(struct dx_mesh_edges *e, const uint32_t *index, uint32_t n)
{
    uint32_t sum = 0;

    for (uint32_t c = 0; c < n; c++) {
        const uint32_t a = index[c], b = index[dx_corner_next(c)];

        e->end[a < b ? a : b]++;
    }
    for (uint32_t v = 0; v < e->n_vertices; v++) {
        const uint32_t size = e->end[v];

        e->end[v] = sum;
        sum += size;
    }
    for (uint32_t c = 0; c < n; c++) {
        const uint32_t a = index[c], b = index[dx_corner_next(c)];

        e->edge[e->end[a < b ? a : b]++] = (struct dx_mesh_edge){a < b ? b : a, c};
    }
    for (uint32_t v = 0, start = 0; v < e->n_vertices; start = e->end[v++])
        sort_bucket(e->edge + start, e->end[v] - start);
}

int dx_mesh_edges_init(struct dx_mesh_edges *e, const uint32_t *index, uint64_t n_triangles,
                       uint32_t n_vertices)
{
    const uint64_t n = 3 * n_triangles;

    *e = (struct dx_mesh_edges){.n_vertices = n_vertices};
    if (n > UINT32_MAX)
        return -EOVERFLOW;
    e->end = calloc((size_t)n_vertices + 1, sizeof(*e->end));
    e->edge = calloc(n + 1, sizeof(*e->edge));
    if (!e->end || !e->edge) {
        dx_mesh_edges_fini(e);
        return -ENOMEM;
    }
    sort_edges(e, index, (uint32_t)n);
    return 0;
}

void dx_mesh_edges_fini(struct dx_mesh_edges *e)
{
    free(e->end);
    free(e->edge);
    *e = (struct dx_mesh_edges){0};
}

bool dx_mesh_edges_next(const struct dx_mesh_edges *e, struct dx_edge_run *run)
{
    const uint32_t i = run->next;

    while (run->low < e->n_vertices && i == e->end[run->low])
        run->low++;
    if (run->low == e->n_vertices)
        return false;
    run->edge = e->edge + i;
    run->n = 1;
    while (i + run->n < e->end[run->low] && run->edge[run->n].high == run->edge->high)
        run->n++;
    run->next = i + run->n;
    return true;
}

bool dx_mesh_edges_has(const struct dx_mesh_edges *e, uint32_t a, uint32_t b)
{
    const uint32_t low = a < b ? a : b, high = a < b ? b : a, end = e->end[low];
    uint32_t from = low ? e->end[low - 1] : 0, to = end;

    while (from < to) {
        const uint32_t middle = from + (to - from) / 2;

        if (e->edge[middle].high < high)
            from = middle + 1;
        else
            to = middle;
    }
    return from < end && e->edge[from].high == high;
}
