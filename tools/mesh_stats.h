/*
 * What a welded mesh is, in numbers: for --stats and for tests. Linear in the mesh for any mesh
 * that a scanner's grid can give.
 */
#ifndef DX_MESH_STATS_H
#define DX_MESH_STATS_H

#include "tools/mesh.h"

struct dx_mesh_stats {
    uint32_t points; /* vertices that a triangle uses */
    uint32_t triangles;
    uint64_t edges;                    /* undirected */
    uint64_t boundary_edges;           /* of one triangle */
    uint64_t nonmanifold_edges;        /* of three or more */
    uint64_t duplicate_directed_edges; /* times an edge runs again in a direction it ran before */
    uint32_t components;               /* sets of triangles that share vertices */
    int64_t euler;                     /* points - edges + triangles */
    uint64_t digest; /* of ids, coordinate bits, attributes, triangles; of no order or encoding of
                        tiles */
};

/* Errors: -ENOMEM. */
int dx_mesh_stats_compute(struct dx_mesh_stats *stats, const struct dx_mesh *mesh);

/* The digest alone: the same on every machine. */
uint64_t dx_mesh_digest(const struct dx_mesh *mesh);

#endif
