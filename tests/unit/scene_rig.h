/* What the tests of scenes and of the synthetic driver share. cmocka.h comes before. */
#ifndef DX_TEST_SCENE_RIG_H
#define DX_TEST_SCENE_RIG_H

#include "drivers/synth/scene.h"

#include <string.h>

/* One scene with its geometry and a plane. */
struct rig {
    struct dx_scene_config config;
    struct dx_geometry *g;
    struct dx_plane plane;
};

static inline void rig_init(struct rig *r, enum dx_scene scene, uint32_t height, uint32_t width)
{
    memset(r, 0, sizeof(*r));
    dx_scene_config_default(&r->config, scene);
    r->config.height = height;
    r->config.width = width;
    r->config.attr_bytes = 2;
}

/* With the rig's configuration as it stands now. */
static inline void rig_open(struct rig *r)
{
    struct dx_geometry *g;

    assert_int_equal(dx_scene_geometry(&g, &r->config), 0);
    assert_int_equal(
        dx_plane_init(&r->plane, g->height, g->width, g->range_bytes, r->config.attr_bytes), 0);
    r->g = g;
}

static inline void rig_cast(struct rig *r, uint64_t number)
{
    dx_scene_cast(&r->plane, r->g, &r->config, number, 0, r->g->width);
}

static inline void rig_close(struct rig *r)
{
    dx_geometry_unref(r->g);
    dx_plane_fini(&r->plane);
}

static inline bool same(const struct dx_plane *a, const struct dx_plane *b)
{
    size_t n = dx_plane_n_dexels(a);

    return n == dx_plane_n_dexels(b) && a->range_bytes == b->range_bytes &&
           memcmp(a->range, b->range, n * a->range_bytes) == 0 &&
           memcmp(a->attr, b->attr, n * a->attr_bytes) == 0;
}

static inline double truth(const struct rig *r, uint64_t number, uint32_t row, uint32_t col)
{
    return dx_scene_truth(r->g, &r->config, number, row, col);
}

#endif
