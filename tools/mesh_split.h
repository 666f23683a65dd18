/*
 * Bow-ties apart: where several fans of triangles meet in one vertex alone, each but the first gets
 * a vertex of its own, at the same place. The mesh is then a manifold with boundary in the strict
 * sense, as some tools want it. One thread.
 */
#ifndef DX_MESH_SPLIT_H
#define DX_MESH_SPLIT_H

#include "tools/mesh.h"

/* New vertices follow the others and bear the id, attribute and normal of the one they were. The
 * mesh's edges are manifold (no directed edge occurs twice). Returns how many there are. Errors:
 * -EOVERFLOW, -ENOMEM; the mesh is then as it was. */
int64_t dx_mesh_split(struct dx_mesh *mesh);

#endif
