/*
 * Terrain mode on the simulated scenes, with noise, drop-outs and mixed pixels, counted both ways
 * round, under every variant of the rules: the invariants (docs/terrain.md: T1 to T5), and the
 * oracle's mesh.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "terrain_rig.h"

static void check_scene(enum dx_scene scene, const struct variant *v, unsigned handedness,
                        uint32_t height, uint32_t width)
{
    struct dx_terrain_params q;
    struct dx_scene_config c;
    struct dx_geometry *g;
    struct dx_terrain *t;
    struct dx_plane p;

    rough_scene(&c, scene, height, width);
    c.flip_rows = handedness & 1;
    c.flip_cols = handedness & 2;
    g = scene_frame(&c, &p);
    use_variant(&q, v);
    t = meshed(g, &q, &p, NULL);
    assert_true(assert_right(t) > (size_t)height * width / 16);
    dx_terrain_free(t);
    dx_plane_fini(&p);
    dx_geometry_unref(g);
}

/* Partial tiles at both ends; on one side a tile of a single cell. */
static void every_scene_both_ways_round(void **state)
{
    (void)state;
    for (unsigned s = 0; s < DX_N_SCENES; s++)
        for (unsigned v = 0; v < N_VARIANTS; v++)
            for (unsigned handedness = (s + v) % 2; handedness < 4; handedness += 2)
                check_scene((enum dx_scene)s, &variants[v], handedness, 66, 90);
}

static void larger_scenes(void **state)
{
    const bool full = long_run();

    (void)state;
    for (unsigned s = 0; s < DX_N_SCENES; s++)
        for (int v = 0; v < (full ? N_VARIANTS : 1); v++)
            check_scene((enum dx_scene)s, &variants[full ? v : (int)s % N_VARIANTS], s % 4,
                        full ? 1000 : 150, full ? 1500 : 200);
}

/* The 64-bit arithmetic decides as the 16-bit one. */
static void wide_equals_narrow(void **state)
{
    (void)state;
    for (int v = 0; v < N_VARIANTS; v++) {
        struct dx_terrain_params q;
        struct dx_scene_config c;
        struct dx_geometry *g, *g4;
        struct dx_plane p, p4;
        struct dx_terrain *t, *t4;
        struct whole_mesh w, w4;

        rough_scene(&c, DX_SCENE_HALL, 130, 200);
        g = scene_frame(&c, &p);
        assert_int_equal(dx_scene_geometry(&g4, &c), 0);
        g4->range_bytes = 4;
        assert_int_equal(dx_plane_init(&p4, g->height, g->width, 4, 0), 0);
        for (size_t k = 0; k < dx_plane_n_dexels(&p); k++)
            dx_plane_set_range(&p4, k, dx_plane_range(&p, k));
        use_variant(&q, &variants[v]);
        t = meshed(g, &q, &p, NULL);
        t4 = meshed(g4, &q, &p4, NULL);
        w = collect(t);
        w4 = collect(t4);
        assert_same_mesh(&w, &w4);
        free(w.triangle);
        free(w4.triangle);
        dx_terrain_free(t);
        dx_terrain_free(t4);
        dx_plane_fini(&p);
        dx_plane_fini(&p4);
        dx_geometry_unref(g);
        dx_geometry_unref(g4);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_scene_both_ways_round),
        cmocka_unit_test(larger_scenes),
        cmocka_unit_test(wide_equals_narrow),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
