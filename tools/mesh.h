/*
 * A welded triangle mesh: every vertex once, in ascending dexel id, and triangles as indices into
 * them. What the writers, the statistics and the renderer take. Owned by one thread.
 */
#ifndef DX_MESH_H
#define DX_MESH_H

#include <stddef.h>
#include <stdint.h>

/* Vertices are named in 31 bits (struct dx_mesh_stats packs a direction beside one). */
#define DX_MESH_MAX_VERTICES  (1u << 31)
#define DX_MESH_MAX_TRIANGLES (1u << 30)

struct dx_mesh {
    uint32_t n_vertices, n_triangles;
    uint8_t attr_bytes; /* 0, 1, 2 */
    float *xyz;         /* [n_vertices][3], metres, scanner frame */
    uint32_t *id;       /* [n_vertices] row * width + column, ascending; NULL: not from a grid */
    uint16_t *attr;     /* [n_vertices], NULL when attr_bytes is 0 */
    float *normal;      /* [n_vertices][3], unit length; NULL: none */
    uint32_t *index;    /* [n_triangles][3] */
};

/* Room for the counts, members as attr_bytes and `with_id` say. Errors: -EINVAL (above the maxima),
 * -ENOMEM; then *mesh is zeroed. */
int dx_mesh_init(struct dx_mesh *mesh, size_t n_vertices, size_t n_triangles, uint8_t attr_bytes,
                 int with_id);
/* Room for the normals of a mesh that was made without; not filled. Errors: -ENOMEM. */
int dx_mesh_add_normals(struct dx_mesh *mesh);
void dx_mesh_fini(struct dx_mesh *mesh);

#endif
