/* What is no surface is left out; then pairs, sides, fans, until every edge is of two triangles at
 * most; then holes. */
#include "tools/mesh_repair_priv.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* Triangles that `drop` marks are left out; how many. */
static uint32_t drop_marked(struct dx_mesh *mesh, const uint8_t *drop)
{
    const uint32_t n_before = mesh->n_triangles;
    uint32_t n = 0;

    for (uint32_t t = 0; t < n_before; t++)
        if (!drop[t])
            memmove(mesh->index + 3 * (size_t)n++, mesh->index + 3 * (size_t)t,
                    3 * sizeof(*mesh->index));
    mesh->n_triangles = n;
    return n_before - n;
}

static void mark_degenerate(uint8_t *drop, const struct dx_mesh *mesh)
{
    for (size_t t = 0; t < mesh->n_triangles; t++) {
        const uint32_t *v = mesh->index + 3 * t;

        drop[t] = v[0] == v[1] || v[1] == v[2] || v[2] == v[0];
    }
}

/* ---- triangles twice -------------------------------------------------------------------------
 */

static uint32_t opposite(const struct dx_mesh *mesh, uint32_t corner)
{
    return mesh->index[dx_corner_next(dx_corner_next(corner))];
}

/* Of an edge: the vertex opposite to it in a triangle, and which triangle. */
struct third {
    uint32_t vertex, triangle;
};

static int compare_thirds(const void *a, const void *b)
{
    const struct third *x = a, *y = b;

    return x->vertex != y->vertex ? (x->vertex > y->vertex) - (x->vertex < y->vertex)
                                  : (x->triangle > y->triangle) - (x->triangle < y->triangle);
}

/* Triangles at one edge with one opposite vertex are the same: all but the first. */
static void mark_run(uint8_t *drop, struct third *third, const struct dx_mesh *mesh,
                     const struct dx_edge_run *run)
{
    for (uint32_t k = 0; k < run->n; k++)
        third[k] = (struct third){opposite(mesh, run->edge[k].corner), run->edge[k].corner / 3};
    qsort(third, run->n, sizeof(*third), compare_thirds);
    for (uint32_t k = 1; k < run->n; k++)
        if (third[k].vertex == third[k - 1].vertex)
            drop[third[k].triangle] = 1;
}

static uint32_t longest_run(const struct dx_mesh_edges *edges)
{
    struct dx_edge_run run = {0};
    uint32_t n = 0;

    while (dx_mesh_edges_next(edges, &run))
        n = run.n > n ? run.n : n;
    return n;
}

static int mark_duplicates(uint8_t *drop, const struct dx_mesh *mesh)
{
    struct dx_edge_run run = {0};
    struct dx_mesh_edges edges;
    struct third *third;
    int rc = dx_mesh_edges_init(&edges, mesh->index, mesh->n_triangles, mesh->n_vertices);

    if (rc < 0)
        return rc;
    third = malloc(longest_run(&edges) * sizeof(*third) + 1);
    memset(drop, 0, mesh->n_triangles);
    while (third && dx_mesh_edges_next(&edges, &run))
        if (run.n > 1)
            mark_run(drop, third, mesh, &run);
    dx_mesh_edges_fini(&edges);
    rc = third ? 0 : -ENOMEM;
    free(third);
    return rc;
}

/* ---- edges that have more triangles still -----------------------------------------------------
 */

/* Both ends of a pinched edge are one fan each: it stays with its first pair of mates, or with its
 * first triangle. */
static void mark_pinched(uint8_t *drop, const uint32_t *mate, const struct dx_mesh *mesh,
                         const struct dx_edge_run *run)
{
    uint32_t keep[2] = {run->edge[0].corner, run->edge[0].corner};

    for (uint32_t k = run->n; k-- > 0;)
        if (mate[run->edge[k].corner] != DX_REPAIR_NONE)
            memcpy(keep, (uint32_t[2]){run->edge[k].corner, mate[run->edge[k].corner]},
                   sizeof(keep));
    for (uint32_t k = 0; k < run->n; k++) {
        const uint32_t c = run->edge[k].corner;
        const bool against = mesh->index[c] != mesh->index[keep[0]];

        if (c != keep[0] && c != keep[1] && (run->n > 2 || !against))
            drop[c / 3] = 1;
    }
}

/* Leaves out what keeps an edge from being of two triangles; 0: there is nothing, else how many;
 * negative: no memory. */
static int64_t remove_pinched(struct dx_mesh *mesh, uint8_t *drop, const uint32_t *mate)
{
    struct dx_edge_run run = {0};
    struct dx_mesh_edges edges;
    int rc = dx_mesh_edges_init(&edges, mesh->index, mesh->n_triangles, mesh->n_vertices);

    if (rc < 0)
        return rc;
    memset(drop, 0, mesh->n_triangles);
    while (dx_mesh_edges_next(&edges, &run))
        if (run.n > 1)
            mark_pinched(drop, mate, mesh, &run);
    dx_mesh_edges_fini(&edges);
    return drop_marked(mesh, drop);
}

/* One round of pairs, sides and fans. */
static int make_manifold(struct dx_mesh *mesh, uint32_t *mate, struct dx_mesh_repair *counts)
{
    struct dx_mesh_edges edges;
    int rc = dx_mesh_edges_init(&edges, mesh->index, mesh->n_triangles, mesh->n_vertices);

    if (rc < 0)
        return rc;
    counts->nonmanifold += dx_repair_pair(mate, mesh, &edges);
    dx_mesh_edges_fini(&edges);
    rc = dx_repair_orient(mesh, mate, counts);
    return rc < 0 ? rc : dx_repair_split(mesh, mate, counts);
}

static int repair(struct dx_mesh *mesh, uint32_t max_hole, uint8_t *drop, uint32_t *mate,
                  struct dx_mesh_repair *counts)
{
    int64_t n_removed = 0;
    int rc;

    mark_degenerate(drop, mesh);
    counts->degenerate = drop_marked(mesh, drop);
    rc = mark_duplicates(drop, mesh);
    if (rc < 0)
        return rc;
    counts->duplicate = drop_marked(mesh, drop);
    do {
        rc = make_manifold(mesh, mate, counts);
        n_removed = rc < 0 ? rc : remove_pinched(mesh, drop, mate);
        counts->removed += n_removed > 0 ? (uint32_t)n_removed : 0;
    } while (n_removed > 0);
    if (n_removed < 0)
        return (int)n_removed;
    return max_hole ? dx_repair_holes(mesh, max_hole, counts) : 0;
}

int dx_mesh_repair(struct dx_mesh *mesh, uint32_t max_hole, struct dx_mesh_repair *counts)
{
    const size_t n = mesh->n_triangles;
    uint8_t *drop = malloc(n + 1);
    uint32_t *mate = malloc(3 * n * sizeof(*mate) + 1);
    int rc = -ENOMEM;

    *counts = (struct dx_mesh_repair){0};
    if (drop && mate)
        rc = repair(mesh, max_hole, drop, mate, counts);
    free(drop);
    free(mate);
    return rc;
}
