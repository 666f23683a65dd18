/*
 * Any triangle mesh made a manifold whose triangles agree on their side: what three and more
 * triangles share at an edge is told apart, vertices of several fans get one for each, small holes
 * are closed. Deterministic: of several ways the one of the lowest numbers is taken. One thread.
 */
#ifndef DX_MESH_REPAIR_H
#define DX_MESH_REPAIR_H

#include "tools/mesh.h"

#define DX_MESH_REPAIR_MAX_HOLE 64 /* edges */
#define DX_MESH_REPAIR_HOLE     16 /* unless told otherwise */

struct dx_mesh_repair {
    uint32_t degenerate;     /* triangles of two equal corners, left out */
    uint32_t duplicate;      /* triangles with the corners of another one, left out */
    uint32_t nonmanifold;    /* edges of three and more triangles, told apart in pairs */
    uint32_t turned;         /* triangles that face the other side now */
    uint32_t cut;            /* edges cut because the surface has one side only */
    uint32_t split;          /* vertices added for fans that shared one */
    uint32_t removed;        /* triangles left out, of edges that could not be told apart */
    uint32_t holes;          /* closed */
    uint32_t hole_triangles; /* for that */
};

/*
 * Holes of at most `max_hole` edges (0 to DX_MESH_REPAIR_MAX_HOLE) are closed, but for those whose
 * cover would be more than half of the component: they are its rim. Vertices that no triangle uses
 * are dropped. Errors: -EOVERFLOW, -ENOMEM; the mesh is then valid, and nothing else is sure.
 */
int dx_mesh_repair(struct dx_mesh *mesh, uint32_t max_hole, struct dx_mesh_repair *counts);

#endif
