/* Meshes of few vertices, so that their triangles meet in every way: what is repaired must be a
 * manifold whose triangles agree, and stay so when it is repaired again. */
#include "tools/mesh_repair.h"
#include "tools/mesh_stats.h"
#include "tools/mesh_topology.h"

#include <stdlib.h>

#define MAX_VERTICES  24
#define MAX_TRIANGLES 400

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len);

static void check(const struct dx_mesh *mesh)
{
    struct dx_mesh_topology topology;
    struct dx_mesh_stats stats;

    if (dx_mesh_stats_compute(&stats, mesh) < 0 || dx_mesh_topology_compute(&topology, mesh) < 0)
        return;
    if (stats.nonmanifold_edges || stats.duplicate_directed_edges || topology.nonmanifold_vertices)
        abort();
}

/* Two bytes: vertices, edges of a hole; three a vertex; then three a triangle. */
int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len)
{
    const uint32_t n_vertices = len ? 3 + bytes[0] % (MAX_VERTICES - 2) : 3;
    const size_t head = 2 + 3 * (size_t)n_vertices;
    struct dx_mesh_repair counts;
    struct dx_mesh mesh;
    size_t n;

    if (len < head)
        return 0;
    n = (len - head) / 3 < MAX_TRIANGLES ? (len - head) / 3 : MAX_TRIANGLES;
    if (dx_mesh_init(&mesh, n_vertices, n, 0, 0) < 0)
        return 0;
    for (size_t k = 0; k < 3 * (size_t)n_vertices; k++)
        mesh.xyz[k] = (float)bytes[2 + k];
    for (size_t k = 0; k < 3 * n; k++)
        mesh.index[k] = bytes[head + k] % n_vertices;
    if (dx_mesh_repair(&mesh, bytes[1] % (DX_MESH_REPAIR_MAX_HOLE + 1), &counts) == 0) {
        check(&mesh);
        if (dx_mesh_repair(&mesh, 0, &counts) == 0 &&
            (counts.turned || counts.removed || counts.split || counts.nonmanifold))
            abort();
    }
    dx_mesh_fini(&mesh);
    return 0;
}
