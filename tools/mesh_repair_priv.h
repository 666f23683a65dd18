/* The steps of mesh_repair.c, in their order. Each takes a mesh whose triangles have three
 * different corners. */
#ifndef DX_MESH_REPAIR_PRIV_H
#define DX_MESH_REPAIR_PRIV_H

#include "tools/mesh_edges.h"
#include "tools/mesh_repair.h"

#define DX_REPAIR_NONE UINT32_MAX

/* mate[corner]: the corner whose edge is the other side of this one's; DX_REPAIR_NONE: it is a
 * rim. Of three and more triangles at an edge those become mates that go through it most straight,
 * first such that agree on their side. Returns how many edges were of that kind. */
uint32_t dx_repair_pair(uint32_t *mate, const struct dx_mesh *mesh,
                        const struct dx_mesh_edges *edges);

/* Turns triangles so that mates run against each other, the fewer of each component; cuts where
 * that cannot be. `mate` follows. Errors: -ENOMEM. */
int dx_repair_orient(struct dx_mesh *mesh, uint32_t *mate, struct dx_mesh_repair *counts);

/* A vertex for each fan of mates; unused vertices go. Errors: -EOVERFLOW, -ENOMEM. */
int dx_repair_split(struct dx_mesh *mesh, const uint32_t *mate, struct dx_mesh_repair *counts);

/* Closes holes of a manifold whose triangles agree. Errors: -EOVERFLOW, -ENOMEM. */
int dx_repair_holes(struct dx_mesh *mesh, uint32_t max_hole, struct dx_mesh_repair *counts);

#endif
