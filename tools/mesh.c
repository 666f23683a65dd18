/* Memory of a welded mesh. */
#include "tools/mesh.h"

#include <errno.h>
#include <stdlib.h>

int dx_mesh_init(struct dx_mesh *mesh, size_t n_vertices, size_t n_triangles, uint8_t attr_bytes,
                 int with_id)
{
    *mesh = (struct dx_mesh){.attr_bytes = attr_bytes};
    if (n_vertices > DX_MESH_MAX_VERTICES || n_triangles > DX_MESH_MAX_TRIANGLES)
        return -EINVAL;
    mesh->n_vertices = (uint32_t)n_vertices;
    mesh->n_triangles = (uint32_t)n_triangles;
    mesh->xyz = malloc(n_vertices * 3 * sizeof(*mesh->xyz) + 1);
    mesh->index = malloc(n_triangles * 3 * sizeof(*mesh->index) + 1);
    if (with_id)
        mesh->id = malloc(n_vertices * sizeof(*mesh->id) + 1);
    if (attr_bytes)
        mesh->attr = malloc(n_vertices * sizeof(*mesh->attr) + 1);
    if (mesh->xyz && mesh->index && (mesh->id || !with_id) && (mesh->attr || !attr_bytes))
        return 0;
    dx_mesh_fini(mesh);
    return -ENOMEM;
}

int dx_mesh_add_normals(struct dx_mesh *mesh)
{
    mesh->normal = malloc((size_t)mesh->n_vertices * 3 * sizeof(*mesh->normal) + 1);
    return mesh->normal ? 0 : -ENOMEM;
}

void dx_mesh_fini(struct dx_mesh *mesh)
{
    free(mesh->normal);
    free(mesh->xyz);
    free(mesh->id);
    free(mesh->attr);
    free(mesh->index);
    *mesh = (struct dx_mesh){0};
}
