/*
 * The edges of a triangle mesh in order, so that all triangles at one edge stand beside each other.
 * Corner c is vertex index[c] of triangle c / 3, and names the edge from there to the triangle's
 * next corner. Any mesh, also one that is no manifold. Owned by one thread.
 */
#ifndef DX_MESH_EDGES_H
#define DX_MESH_EDGES_H

#include <stdbool.h>
#include <stdint.h>

struct dx_mesh_edge {
    uint32_t high; /* the higher of its vertices */
    uint32_t corner;
};

struct dx_mesh_edges {
    uint32_t n_vertices;
    uint32_t *end;             /* [n_vertices + 1] of the edges under their lower vertex */
    struct dx_mesh_edge *edge; /* by lower vertex, higher vertex, corner */
};

static inline uint32_t dx_corner_next(uint32_t corner)
{
    return corner % 3 == 2 ? corner - 2 : corner + 1;
}

/* Errors: -EOVERFLOW (2^32 corners), -ENOMEM; then *e is zeroed. */
int dx_mesh_edges_init(struct dx_mesh_edges *e, const uint32_t *index, uint64_t n_triangles,
                       uint32_t n_vertices);
void dx_mesh_edges_fini(struct dx_mesh_edges *e);

/* All triangles at one edge. Zeroed is before the first. */
struct dx_edge_run {
    uint32_t low; /* the lower vertex */
    struct dx_mesh_edge *edge;
    uint32_t n;
    uint32_t next; /* where the run after it starts */
};

/* Goes to the next run; false: there is none. */
bool dx_mesh_edges_next(const struct dx_mesh_edges *e, struct dx_edge_run *run);

/* Some triangle has this edge, in either direction. */
bool dx_mesh_edges_has(const struct dx_mesh_edges *e, uint32_t a, uint32_t b);

#endif
