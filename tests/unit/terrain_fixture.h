/* A whole frame's mesh from its tiles, as global triangles, and the checks that every such mesh
 * passes. */
#ifndef DX_TERRAIN_FIXTURE_H
#define DX_TERRAIN_FIXTURE_H

#include "core/base/hash.h"
#include "core/grid/terrain.h"

#include <stdlib.h>
#include <string.h>

struct triangle {
    uint32_t v[3]; /* row * width + col; rotated so that the smallest is first */
};

struct whole_mesh {
    struct triangle *triangle;
    size_t n;
};

static inline int by_vertices(const void *a, const void *b)
{
    return memcmp(a, b, sizeof(struct triangle)); /* an order, whichever */
}

static inline struct triangle rotated(uint32_t a, uint32_t b, uint32_t c)
{
    if (a < b && a < c)
        return (struct triangle){{a, b, c}};
    return b < c ? (struct triangle){{b, c, a}} : (struct triangle){{c, a, b}};
}

/* Asserts T1 on the way: vertices are the points of published dexels, bit for bit. */
static inline struct whole_mesh collect(const struct dx_terrain *t)
{
    const struct dx_tiling *tiling = dx_terrain_tiling(t);
    const struct dx_geometry *g = dx_terrain_geometry(t);
    const struct dx_plane *plane = dx_terrain_published(t);
    struct dx_tile *tile = calloc(1, sizeof(*tile));
    struct dx_tile_mesh *mesh = malloc(sizeof(*mesh));
    uint32_t *id = malloc(DX_TILE_MAX_VERTICES * sizeof(*id));
    struct whole_mesh w = {.triangle =
                               malloc((2 * (size_t)tiling->cell_rows * tiling->cell_cols + 1) *
                                      sizeof(struct triangle))};

    for (uint32_t n = 0; n < dx_tiling_n_tiles(tiling); n++) {
        uint32_t n_vertices = 0;

        if (!dx_terrain_tile(t, n, tile))
            continue;
        dx_tile_mesh_build(mesh, tile, tiling, g);
        for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
            if (mesh->mask[k / 8] >> (k % 8) & 1) {
                uint64_t v = dx_tile_vertex_id(tiling, tile->row, tile->col, k);
                float p[3];

                dx_geometry_point(g, (uint32_t)(v / g->width), (uint32_t)(v % g->width),
                                  dx_plane_range(plane, v), p);
                assert_true(dx_plane_range(plane, v) != 0);
                assert_memory_equal(p, mesh->xyz + 3 * (size_t)n_vertices, sizeof(p));
                id[n_vertices++] = (uint32_t)v;
            }
        assert_int_equal(n_vertices, mesh->n_vertices);
        for (uint32_t k = 0; k < mesh->n_triangles; k++) {
            const uint16_t *i = mesh->index + 3 * (size_t)k;

            assert_true(i[0] < n_vertices && i[1] < n_vertices && i[2] < n_vertices);
            w.triangle[w.n++] = rotated(id[i[0]], id[i[1]], id[i[2]]);
        }
    }
    qsort(w.triangle, w.n, sizeof(struct triangle), by_vertices);
    free(id);
    free(mesh);
    free(tile);
    return w;
}

static inline uint64_t mesh_digest(const struct whole_mesh *w)
{
    return dx_hash(0, w->triangle, w->n * sizeof(struct triangle));
}

#endif
