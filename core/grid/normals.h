/*
 * Vertex normals: the sum of (p1 - p0) x (p2 - p0) over the triangles at a vertex, so weighted by
 * area, in octahedral bytes (ALGORITHMS 1.10). Triangles of neighbouring tiles count too, and the
 * sum is always made in the same order, so that a vertex on a border gets the same bytes in every
 * tile. Pure function of codes, ranges and geometry; any thread.
 */
#ifndef DX_NORMALS_H
#define DX_NORMALS_H

#include "core/grid/plane.h"
#include "core/grid/tile.h"

/* What the mesh is made of. Tile n is (n / cols, n % cols). */
struct dx_normals_source {
    const struct dx_plane *plane; /* the published array */
    const struct dx_tiling *tiling;
    const struct dx_geometry *geometry;
    const void *ctx;
    const uint8_t *(*cells)(const void *ctx, uint32_t tile);  /* as `code` of struct dx_tile */
    const uint8_t *(*struts)(const void *ctx, uint32_t tile); /* as `strut`; NULL: it has none */
};

/* Fills `normal` of a tile whose row, col, codes and struts are filled, and sets `has_normals`.
 * Block dexels that are no vertex get 0, 0. */
void dx_normals_compute(struct dx_tile *tile, const struct dx_normals_source *source);

#endif
