/*
 * A triangle mesh as half-edges: each edge is two that run in opposite directions, numbers 2k and
 * 2k
 * + 1. What has no triangle on its left is a border half-edge; those are joined into loops, with
 * the hole or the outside on their left. All operations keep the mesh manifold and oriented: a
 * directed edge exists once at most. A vertex may be shared by several fans until
 * dx_halfedges_split_fans; each gap between two of them is a corner of a border. Owned by one
 * thread.
 */
#ifndef DX_HALFEDGE_H
#define DX_HALFEDGE_H

#include <stdbool.h>
#include <stdint.h>

#define DX_NO_HALFEDGE UINT32_MAX

struct dx_halfedge {
    uint32_t to;         /* vertex */
    uint32_t next, prev; /* of the same triangle or border */
    uint32_t face;       /* DX_NO_HALFEDGE: border */
};

struct dx_halfedges {
    struct dx_halfedge *of;
    uint32_t n, cap;
    uint32_t *out; /* [n_vertices] one that leaves the vertex, DX_NO_HALFEDGE: it has none */
    uint32_t n_vertices, cap_vertices;
    uint32_t *face; /* [n_faces] one of each triangle */
    uint32_t n_faces, cap_faces;
};

/* Vertices without edges. Errors: -ENOMEM. */
int dx_halfedges_init(struct dx_halfedges *m, uint32_t n_vertices);
void dx_halfedges_fini(struct dx_halfedges *m);

static inline uint32_t dx_halfedge_twin(uint32_t h)
{
    return h ^ 1;
}

static inline uint32_t dx_halfedge_from(const struct dx_halfedges *m, uint32_t h)
{
    return m->of[h ^ 1].to;
}

static inline bool dx_halfedge_is_border(const struct dx_halfedges *m, uint32_t h)
{
    return m->of[h].face == DX_NO_HALFEDGE;
}

/* The next that leaves the same vertex, to the left around it. */
static inline uint32_t dx_halfedge_around(const struct dx_halfedges *m, uint32_t h)
{
    return m->of[h].prev ^ 1;
}

/* The vertex across from a half-edge of a triangle. */
static inline uint32_t dx_halfedge_apex(const struct dx_halfedges *m, uint32_t h)
{
    return m->of[m->of[h].next].to;
}

/* From u to v, or DX_NO_HALFEDGE. */
uint32_t dx_halfedge_find(const struct dx_halfedges *m, uint32_t u, uint32_t v);

/* A border half-edge that leaves the vertex; DX_NO_HALFEDGE: there is none. */
uint32_t dx_halfedge_corner(const struct dx_halfedges *m, uint32_t v);

/* All operations. Errors: -ENOMEM, the mesh is as before. */

int dx_halfedges_add_vertex(struct dx_halfedges *m, uint32_t *v);

/* A triangle of three vertices without edges. */
int dx_halfedges_add_triangle(struct dx_halfedges *m, uint32_t a, uint32_t b, uint32_t c);

/* Whether triangle (u, v, q) may be made on the left of border half-edge b, u to v. `corner`: where
 * q has edges, the border half-edge that leaves q from the gap in which the triangle lies; not used
 * when q is next to the edge on its border. */
bool dx_halfedge_fits(const struct dx_halfedges *m, uint32_t b, uint32_t q, uint32_t corner);

/* Makes that triangle, which fits. */
int dx_halfedges_glue(struct dx_halfedges *m, uint32_t b, uint32_t q, uint32_t corner);

/* Puts vertex v, which has no edges, on the edge; each triangle beside it becomes two. */
int dx_halfedges_split_edge(struct dx_halfedges *m, uint32_t h, uint32_t v);

/* Whether the edge has two triangles and the other diagonal is none of the mesh. */
bool dx_halfedge_may_flip(const struct dx_halfedges *m, uint32_t h);
void dx_halfedges_flip(struct dx_halfedges *m, uint32_t h);

/* Gives each fan but the first of a vertex a vertex of its own; told as (old, new). */
int dx_halfedges_split_fans(struct dx_halfedges *m,
                            int (*copied)(void *ctx, uint32_t old, uint32_t made), void *ctx);

#endif
