/* What the tests of publishing share: terrains of simulated and of flat scenes, and commits that
 * are checked. cmocka.h comes before. */
#ifndef DX_TEST_PUBLISH_FIXTURE_H
#define DX_TEST_PUBLISH_FIXTURE_H

#include "core/grid/tile_hash.h"
#include "scene_rig.h"
#include "terrain_fixture.h"

static inline struct dx_terrain_params params_of(enum dx_filter filter, double hold)
{
    struct dx_terrain_params p;

    dx_terrain_params_default(&p);
    p.ingest.filter = filter;
    p.ingest.hold = hold;
    p.sigma_given = true;
    p.sigma[0] = 0.005;
    return p;
}

/* A rig's terrain. */
static inline struct dx_terrain *terrain_of(const struct rig *r, const struct dx_terrain_params *p)
{
    struct dx_terrain *t;

    assert_int_equal(dx_terrain_new(&t, r->g, p, r->config.attr_bytes), 0);
    return t;
}

static inline void still_hall(struct rig *r, uint32_t height, uint32_t width)
{
    rig_init(r, DX_SCENE_HALL, height, width);
    r->config.sigma[0] = 0.005;
    r->config.dropout = 0.02;
    rig_open(r);
}

/* Hash of each tile's content. */
static inline void hash_tiles(const struct dx_terrain *t, struct dx_tile *tile, uint64_t *hash)
{
    for (uint32_t k = 0; k < dx_tiling_n_tiles(dx_terrain_tiling(t)); k++)
        hash[k] = dx_terrain_tile(t, k, tile) ? dx_tile_hash(tile) : 0;
}

/* Takes columns, commits, and checks that what changed is what is said to have; how much did. */
static inline uint32_t commit_columns(struct dx_terrain *t, const struct rig *r, uint32_t col0,
                                      uint32_t n)
{
    uint32_t n_tiles = dx_tiling_n_tiles(dx_terrain_tiling(t)), n_changed;
    struct dx_tile *tile = malloc(sizeof(*tile));
    uint64_t *before = calloc(n_tiles, sizeof(*before)), *after = calloc(n_tiles, sizeof(*after));

    hash_tiles(t, tile, before);
    dx_terrain_publish(t, &r->plane, col0, n, NULL);
    n_changed = dx_terrain_commit(t, NULL);
    hash_tiles(t, tile, after);
    for (uint32_t k = 0; k < n_tiles; k++)
        assert_int_equal(dx_terrain_changed(t)[k / 64] >> (k % 64) & 1, before[k] != after[k]);
    free(tile);
    free(before);
    free(after);
    return n_changed;
}

/* Two by three tiles; the last ones have one row and one column more. */
#define FLAT_HEIGHT 129
#define FLAT_WIDTH  193

/* A flat 5 m, intensities 1. */
static inline void flat(struct rig *r, uint8_t range_bytes)
{
    memset(r, 0, sizeof(*r));
    r->config.attr_bytes = 1;
    assert_int_equal(
        dx_geometry_new_spinning(&r->g, FLAT_HEIGHT, FLAT_WIDTH, 0, 0.005, -0.3, 0.005), 0);
    r->g->range_bytes = range_bytes;
    assert_int_equal(dx_plane_init(&r->plane, FLAT_HEIGHT, FLAT_WIDTH, range_bytes, 1), 0);
    for (size_t k = 0; k < FLAT_HEIGHT * FLAT_WIDTH; k++) {
        dx_plane_set_range(&r->plane, k, 5000);
        dx_plane_set_attr(&r->plane, k, 1);
    }
}

static inline void set_all(struct rig *r, uint32_t range)
{
    for (size_t k = 0; k < FLAT_HEIGHT * FLAT_WIDTH; k++)
        dx_plane_set_range(&r->plane, k, range);
}

#endif
