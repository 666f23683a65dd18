/*
 * Fans are sets of corners: of the same vertex, joined by common edges. Loops are sets of fans,
 * joined by boundary edges; so loops that touch in a vertex of two fans stay two.
 */
#include "tools/mesh_topology.h"

#include "tools/mesh_edges.h"
#include "tools/union_find.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

struct work {
    const struct dx_mesh *mesh;
    uint32_t n; /* corners */
    struct dx_mesh_edges edges;
    uint32_t *fan;   /* [n] union-find */
    uint32_t *loop;  /* [n] the same, of the fans' roots */
    uint32_t *count; /* [n] edges of a loop; [n_vertices] fans of a vertex */
};

/* The corner of a triangle's edge that is at vertex v. */
static uint32_t corner_at(const struct work *w, uint32_t corner, uint32_t v)
{
    return w->mesh->index[corner] == v ? corner : dx_corner_next(corner);
}

/* Calls `visit` with each run of triangles at one edge. */
static void for_each_edge(struct work *w,
                          void (*visit)(struct work *w, const struct dx_edge_run *run))
{
    struct dx_edge_run run = {0};

    while (dx_mesh_edges_next(&w->edges, &run))
        visit(w, &run);
}

static void join_fans(struct work *w, const struct dx_edge_run *run)
{
    const uint32_t v[2] = {run->low, run->edge->high};

    for (uint32_t i = 1; i < run->n; i++)
        for (int k = 0; k < 2; k++)
            dx_union_join(w->fan, corner_at(w, run->edge[0].corner, v[k]),
                          corner_at(w, run->edge[i].corner, v[k]));
}

static void join_loops(struct work *w, const struct dx_edge_run *run)
{
    const uint32_t corner = run->edge->corner;

    if (run->n == 1)
        dx_union_join(w->loop, dx_union_root(w->fan, corner),
                      dx_union_root(w->fan, dx_corner_next(corner)));
}

static void count_loops(struct work *w, const struct dx_edge_run *run)
{
    if (run->n == 1)
        w->count[dx_union_root(w->loop, dx_union_root(w->fan, run->edge->corner))]++;
}

static void count(struct dx_mesh_topology *t, struct work *w)
{
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
    int rc = dx_mesh_edges_init(&w.edges, mesh->index, mesh->n_triangles, mesh->n_vertices);

    *t = (struct dx_mesh_topology){0};
    if (rc < 0)
        return rc;
    w.fan = malloc(n * sizeof(*w.fan) + 1);
    w.loop = malloc(n * sizeof(*w.loop) + 1);
    w.count = calloc(n + mesh->n_vertices + 1, sizeof(*w.count));
    if (w.fan && w.loop && w.count)
        count(t, &w);
    else
        rc = -ENOMEM;
    dx_mesh_edges_fini(&w.edges);
    free(w.fan);
    free(w.loop);
    free(w.count);
    return rc;
}
