/*
 * What the edges and corners of a mesh are to each other, in numbers, beside those of mesh_stats.h.
 * Any mesh, also one that is no manifold; each triangle has three different corners. One thread.
 */
#ifndef DX_MESH_TOPOLOGY_H
#define DX_MESH_TOPOLOGY_H

#include "tools/mesh.h"

struct dx_mesh_topology {
    uint32_t nonmanifold_vertices; /* where several fans meet: bow-ties */
    uint32_t boundary_loops;       /* sets of boundary edges that fans chain; a manifold's rims */
    uint32_t longest_loop;         /* edges */
};

/* Errors: -EOVERFLOW (2^32 corners), -ENOMEM. */
int dx_mesh_topology_compute(struct dx_mesh_topology *t, const struct dx_mesh *mesh);

#endif
