/* Inside a mesh store: what mesh_store.c keeps and mesh_weld.c reads. Included by these alone. */
#ifndef DX_MESH_STORE_PRIV_H
#define DX_MESH_STORE_PRIV_H

#include "tools/mesh_store.h"

/* One tile's mesh in one allocation. */
struct dx_held {
    uint32_t n_vertices, n_triangles;
    bool has_normals;
    float *xyz, *normal;
    uint32_t *id;
    uint16_t *attr, *index;
};

struct dx_store_caps {
    bool first, last, flip;
};

struct dx_store_slot {
    struct dx_held *now, *next;
    bool touched; /* since the last commit: `next` (NULL: empty) will replace `now` */
};

struct dx_mesh_store {
    struct dx_tiling tiling;
    uint8_t attr_bytes;
    bool cleared; /* since the last commit */
    struct dx_store_caps caps, next_caps;
    uint32_t n_touched;
    uint32_t *touched; /* tile numbers, so that a commit costs what changed */
    uint64_t n_triangles, n_vertices;
    uint32_t n_held;
    struct dx_store_slot *slots;
};

#endif
