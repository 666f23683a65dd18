/*
 * The tiles of a mesh, by tile number, and the welded mesh that they are together. What arrives is
 * held apart until dx_mesh_store_commit: whoever stops in the middle of a batch still has the whole
 * epoch before it. Memory is bounded by the grid: two meshes of a tile at most. Owned by one
 * thread.
 */
#ifndef DX_MESH_STORE_H
#define DX_MESH_STORE_H

#include "core/grid/tile.h"
#include "tools/mesh.h"

#include <stdbool.h>

/* A tile's mesh, as libdexel and the chunk decoder give it; the arrays stay the caller's. */
struct dx_store_tile {
    uint32_t row, col;
    uint32_t n_vertices, n_triangles;
    const float *xyz;      /* [n_vertices][3] */
    const uint16_t *index; /* [n_triangles][3] */
    const uint32_t *id;    /* [n_vertices] row * width + column */
    const uint16_t *attr;  /* [n_vertices], or NULL */
    const float *normal;   /* [n_vertices][3], or NULL */
};

struct dx_mesh_store;

/* An empty mesh of a grid. Errors: -EINVAL (sizes out of plane.h's bounds), -ENOMEM. */
int dx_mesh_store_new(struct dx_mesh_store **out, uint32_t height, uint32_t width, bool wrap,
                      uint8_t attr_bytes);
void dx_mesh_store_free(struct dx_mesh_store *s);

/*
 * Replaces the mesh of a tile from the next commit on; no triangles: removes it. Copies.
 * Errors: -EBADMSG (tile, id or index outside the grid or the tile, too many of either), -ENOMEM.
 */
int dx_mesh_store_set(struct dx_mesh_store *s, const struct dx_store_tile *tile);
/* The same for a tile of core/grid, whose ids follow from its mask. */
int dx_mesh_store_set_mesh(struct dx_mesh_store *s, const struct dx_tile_mesh *mesh);
/* All tiles are gone from the next commit on, save those set after this. */
void dx_mesh_store_reset(struct dx_mesh_store *s);
/* From the next commit on there is a fan over the first or last row, or there is none: polar caps,
 * which are in no tile. `flip`: the stream's. */
void dx_mesh_store_set_caps(struct dx_mesh_store *s, bool first, bool last, bool flip);
/* What was set, removed and reset since the last commit takes effect. */
void dx_mesh_store_commit(struct dx_mesh_store *s);

/* Totals of the committed tiles, without caps; vertices on borders count once for each tile. */
uint64_t dx_mesh_store_n_triangles(const struct dx_mesh_store *s);
uint64_t dx_mesh_store_n_tile_vertices(const struct dx_mesh_store *s);
uint32_t dx_mesh_store_n_tiles(const struct dx_mesh_store *s); /* not empty */

/*
 * The committed tiles as one mesh: vertices that a triangle uses, once each, in ascending id;
 * triangles in tile order, then in the tile's own, then those of the caps. Where two tiles differ
 * about a vertex the first one holds. Normals when all tiles have them. A cap over a row that is
 * not all there (a region without some of its tiles) is left out. Errors: -EOVERFLOW, -ENOMEM.
 */
int dx_mesh_store_weld(struct dx_mesh *mesh, const struct dx_mesh_store *s);

#endif
