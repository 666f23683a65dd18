/*
 * Bow-ties apart: where several fans of triangles meet in one vertex alone, each but the first gets
 * a vertex of its own, at the same place. The mesh is then a manifold with boundary in the strict
 * sense, as some tools want it. One thread.
 */
#ifndef DX_MESH_SPLIT_H
#define DX_MESH_SPLIT_H

#include "tools/mesh.h"

/* New vertices follow the others and bear the id and attribute of the one they were; each fan gets
 * a normal of its own triangles. The mesh's edges are manifold (no directed edge occurs twice).
 * Returns how many there are. Errors: -EOVERFLOW, -ENOMEM; the mesh is valid then too. */
int64_t dx_mesh_split(struct dx_mesh *mesh);

#endif
