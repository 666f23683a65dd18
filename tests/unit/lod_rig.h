/* What the tests of levels of detail share: the mesh of a level from its tiles, and what every such
 * mesh keeps. cmocka.h comes before. */
#ifndef DX_LOD_RIG_H
#define DX_LOD_RIG_H

#include "core/grid/lod.h"
#include "terrain_rig.h"

/* Every tile's triangles as a subscriber holds them: replaced one tile at a time. */
struct lod_tiles {
    uint32_t n_tiles;
    struct whole_mesh *tile;
    struct dx_tile *source;
    struct dx_tile_mesh *whole, *mesh;
    struct dx_lod_scratch *scratch;
};

static inline void lod_tiles_init(struct lod_tiles *s, const struct dx_terrain *t)
{
    s->n_tiles = dx_tiling_n_tiles(dx_terrain_tiling(t));
    s->tile = calloc(s->n_tiles, sizeof(*s->tile));
    s->source = calloc(1, sizeof(*s->source));
    s->whole = calloc(1, sizeof(*s->whole));
    s->mesh = calloc(1, sizeof(*s->mesh));
    s->scratch = dx_lod_scratch_new();
    assert_true(s->tile && s->source && s->whole && s->mesh && s->scratch);
}

static inline void lod_tiles_fini(struct lod_tiles *s)
{
    for (uint32_t n = 0; n < s->n_tiles; n++)
        free(s->tile[n].triangle);
    free(s->tile);
    free(s->source);
    free(s->whole);
    free(s->mesh);
    dx_lod_scratch_free(s->scratch);
}

/* Vertices are points of published dexels, bit for bit (T1). */
static inline void lod_name_vertices(uint32_t *id, const struct dx_tile_mesh *mesh,
                                     const struct dx_terrain *t)
{
    const struct dx_geometry *g = dx_terrain_geometry(t);
    uint32_t n = 0;

    for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++) {
        float p[3];

        if (!(mesh->mask[k / 8] >> (k % 8) & 1))
            continue;
        id[n] = (uint32_t)dx_tile_vertex_id(dx_terrain_tiling(t), mesh->row, mesh->col, k);
        dx_geometry_point(g, id[n] / g->width, id[n] % g->width,
                          dx_plane_range(dx_terrain_published(t), id[n]), p);
        assert_memory_equal(p, mesh->xyz + 3 * (size_t)n, sizeof(p));
        n++;
    }
    assert_int_equal(n, mesh->n_vertices);
}

static inline void lod_tiles_set(struct lod_tiles *s, const struct dx_lod *lod,
                                 struct dx_lod_level level, const struct dx_terrain *t, uint32_t n)
{
    struct whole_mesh *out = &s->tile[n];
    uint32_t id[DX_TILE_MAX_VERTICES];

    free(out->triangle);
    *out = (struct whole_mesh){0};
    if (!dx_terrain_tile(t, n, s->source))
        return;
    dx_tile_mesh_build(s->whole, s->source, dx_terrain_tiling(t), dx_terrain_geometry(t));
    dx_lod_mesh(s->mesh, lod, level, s->source, s->whole, s->scratch);
    lod_name_vertices(id, s->mesh, t);
    out->n = s->mesh->n_triangles;
    out->triangle = malloc(out->n * sizeof(*out->triangle));
    assert_non_null(out->triangle);
    for (size_t k = 0; k < out->n; k++)
        out->triangle[k] = rotated(id[s->mesh->index[3 * k]], id[s->mesh->index[3 * k + 1]],
                                   id[s->mesh->index[3 * k + 2]]);
}

static inline void lod_tiles_set_all(struct lod_tiles *s, const struct dx_lod *lod,
                                     struct dx_lod_level level, const struct dx_terrain *t)
{
    for (uint32_t n = 0; n < s->n_tiles; n++)
        lod_tiles_set(s, lod, level, t, n);
}

static inline struct whole_mesh lod_union(const struct lod_tiles *s)
{
    struct whole_mesh w = {0};

    for (uint32_t n = 0; n < s->n_tiles; n++)
        w.n += s->tile[n].n;
    w.triangle = malloc((w.n + 1) * sizeof(*w.triangle));
    assert_non_null(w.triangle);
    w.n = 0;
    for (uint32_t n = 0; n < s->n_tiles; n++) {
        if (s->tile[n].n)
            memcpy(w.triangle + w.n, s->tile[n].triangle, s->tile[n].n * sizeof(*w.triangle));
        w.n += s->tile[n].n;
    }
    qsort(w.triangle, w.n, sizeof(struct triangle), by_vertices);
    return w;
}

static inline struct dx_lod *lod_of(const struct dx_terrain *t, struct dx_lod_level level,
                                    struct dx_pool *pool)
{
    const struct dx_lod_level levels[DX_LOD_SLOTS] = {level};
    struct dx_lod *lod;

    assert_int_equal(dx_lod_new(&lod, t, pool), 0);
    dx_lod_update(lod, levels, pool);
    return lod;
}

static inline struct whole_mesh lod_mesh_of(const struct dx_terrain *t, struct dx_lod_level level,
                                            struct dx_pool *pool)
{
    struct dx_lod *lod = lod_of(t, level, pool);
    struct lod_tiles s;
    struct whole_mesh w;

    lod_tiles_init(&s, t);
    lod_tiles_set_all(&s, lod, level, t);
    w = lod_union(&s);
    lod_tiles_fini(&s);
    dx_lod_free(lod);
    return w;
}

/* ---- what a level keeps ---------------------------------------------------------------------- */

/* In the index plane, twice; the mesh does not overlap itself, so it covers what the whole one does
 * when the areas are the same and so are the boundaries. */
static inline int64_t lod_area(const struct whole_mesh *w, const struct dx_geometry *g)
{
    int64_t area = 0;

    for (size_t k = 0; k < w->n; k++) {
        const struct flat f = flatten(&w->triangle[k], g);

        assert_true(flat_area(&f) * (g->flip ? -1 : 1) > 0);
        area += llabs(flat_area(&f));
    }
    return area;
}

/* Every face sees the scanner. */
static inline void lod_check_facing(const struct whole_mesh *w, const struct dx_geometry *g)
{
    for (size_t k = 0; k < w->n; k++) {
        double d[3][3];

        for (int m = 0; m < 3; m++)
            dx_geometry_direction(g, w->triangle[k].v[m] / g->width, w->triangle[k].v[m] % g->width,
                                  d[m]);
        assert_true(d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) -
                        d[0][1] * (d[1][0] * d[2][2] - d[1][2] * d[2][0]) +
                        d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]) <
                    0);
    }
}

/* An edge of one triangle is one of the whole mesh, or a piece of the grid's border: nothing is
 * open that was not. */
static inline void lod_check_cracks(const struct half_edges *h, const struct half_edges *whole,
                                    const struct dx_geometry *g)
{
    for (uint32_t e = 0; e < h->n; e++) {
        const uint32_t a = tail(h, e), b = head(h, e);
        uint32_t of_whole;

        if (h->twin[e] != NO_TWIN)
            continue;
        of_whole = find_half_edge(whole, a, b);
        if (of_whole != NO_TWIN) {
            assert_int_equal(whole->twin[of_whole], NO_TWIN);
            continue;
        }
        if (a / g->width == b / g->width)
            assert_true(a / g->width == 0 || a / g->width == g->height - 1);
        else
            assert_true(!g->wrap && a % g->width == b % g->width &&
                        (a % g->width == 0 || a % g->width == g->width - 1));
    }
}

static inline void lod_check(const struct whole_mesh *w, const struct dx_terrain *t)
{
    const struct dx_geometry *g = dx_terrain_geometry(t);
    struct whole_mesh all = collect(t);
    struct half_edges h, whole;

    assert_int_equal(lod_area(w, g), lod_area(&all, g));
    half_edges_init(&h, w, g->height * g->width);
    half_edges_init(&whole, &all, g->height * g->width);
    check_euler(&h);
    check_junctions(w, &h, g);
    lod_check_cracks(&h, &whole, g);
    lod_check_facing(w, g);
    half_edges_fini(&whole);
    half_edges_fini(&h);
    free(all.triangle);
}

#endif
