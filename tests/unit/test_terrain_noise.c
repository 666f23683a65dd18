/* The noise model that terrain mode takes from a frame, and the parameters it accepts. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "terrain_rig.h"

static void noise_is_estimated_within_a_fifth(void **state)
{
    static const double sigmas[] = {0.002, 0.01, 0.05};

    (void)state;
    for (int s = 0; s < 2; s++)
        for (int k = 0; k < 3; k++) {
            struct dx_scene_config c;
            struct dx_geometry *g;
            struct dx_plane p;
            double sigma[3], at5;

            dx_scene_config_default(&c, s ? DX_SCENE_OPEN : DX_SCENE_HALL);
            c.sigma[0] = sigmas[k];
            g = scene_frame(&c, &p);
            dx_noise_estimate(sigma, &p, g);
            at5 = sigma[0] + sigma[2] * 25;
            assert_true(fabs(at5 - sigmas[k]) < 0.2 * sigmas[k]);
            dx_plane_fini(&p);
            dx_geometry_unref(g);
        }
}

/* A camera of few disparities: runs of equal depths, whose median step is 0. Its noise is that of a
 * level, a uniform error, at the least, and not twice that where the level told is right. */
static void levels_are_noise(void **state)
{
    const double step = 0.0028; /* of inverse depth, 1/m: a Kinect's */
    struct dx_scene_config c;
    struct dx_geometry *g;
    struct dx_plane p;
    double sigma[3];

    (void)state;
    dx_scene_config_default(&c, DX_SCENE_MOVING_BOX);
    c.unit_m = 1e-4;
    g = scene_frame(&c, &p);
    for (size_t k = 0; k < dx_plane_n_dexels(&p); k++) {
        double z = dx_plane_range(&p, k) * 1e-4;

        if (z > 0)
            dx_plane_set_range(&p, k, (uint32_t)rint(1e4 / (step * rint(1 / (z * step)))));
    }
    assert_true(dx_noise_estimate(sigma, &p, g));
    for (double z = 2; z <= 4.5; z += 0.5) {
        double level = step * z * z / sqrt(12), told = sigma[0] + sigma[2] * z * z;

        assert_true(told > 0.8 * level && told < 2 * level);
    }
    dx_plane_fini(&p);
    dx_geometry_unref(g);
}

/* Ranges in whole millimetres, without noise: most steps are those of slopes, and the box stands
 * out by half a metre, but the noise is the rounding's. */
static void slopes_and_edges_are_no_levels(void **state)
{
    static const enum dx_scene scenes[] = {DX_SCENE_MOVING_BOX, DX_SCENE_CREASE, DX_SCENE_HALL};

    (void)state;
    for (size_t m = 0; m < sizeof(scenes) / sizeof(scenes[0]); m++) {
        struct dx_scene_config c;
        struct dx_geometry *g;
        struct dx_plane p;
        double sigma[3];

        dx_scene_config_default(&c, scenes[m]);
        c.unit_m = 1e-4;
        g = scene_frame(&c, &p);
        for (size_t k = 0; k < dx_plane_n_dexels(&p); k++)
            dx_plane_set_range(&p, k, (dx_plane_range(&p, k) + 5) / 10 * 10);
        assert_true(dx_noise_estimate(sigma, &p, g));
        assert_true(sigma[0] + 9 * sigma[2] < 0.7e-3);
        dx_plane_fini(&p);
        dx_geometry_unref(g);
    }
}

/* A first frame of a few returns cannot tell the noise: the first that can does, once, for the
 * whole array. */
static void noise_waits_for_a_frame_that_tells(void **state)
{
    struct dx_terrain_params params;
    struct dx_scene_config c;
    struct dx_geometry *g;
    struct dx_plane p, sparse;
    struct dx_terrain *t;
    double settled;

    (void)state;
    dx_scene_config_default(&c, DX_SCENE_HALL);
    c.sigma[0] = 0.01;
    g = scene_frame(&c, &p);
    assert_int_equal(dx_plane_init(&sparse, g->height, g->width, g->range_bytes, 0), 0);
    for (size_t k = 0; k < 600; k += 4)
        dx_plane_set_range(&sparse, k, 3000);
    dx_terrain_params_default(&params);
    t = meshed(g, &params, &sparse, NULL);
    assert_false(dx_terrain_params(t)->sigma_given);
    dx_terrain_publish(t, &p, 0, g->width, NULL);
    dx_terrain_commit(t, NULL);
    settled = dx_terrain_params(t)->sigma[0];
    assert_true(dx_terrain_params(t)->sigma_given && fabs(settled - 0.01) < 0.002);
    assert_like_oracle(t);
    dx_terrain_publish(t, &sparse, 0, g->width, NULL);
    assert_true(dx_terrain_params(t)->sigma[0] == settled);
    dx_terrain_free(t);
    dx_plane_fini(&sparse);
    dx_plane_fini(&p);
    dx_geometry_unref(g);
}

static void bad_parameters_are_named(void **state)
{
    struct dx_terrain_params p;

    (void)state;
    dx_terrain_params_default(&p);
    assert_null(dx_terrain_params_check(&p));
    p.tilt_deg = NAN;
    assert_non_null(dx_terrain_params_check(&p));
    dx_terrain_params_default(&p);
    p.sigma[1] = -1;
    assert_non_null(dx_terrain_params_check(&p));
    dx_terrain_params_default(&p);
    p.paper = true;
    assert_non_null(dx_terrain_params_check(&p));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(noise_is_estimated_within_a_fifth),
        cmocka_unit_test(levels_are_noise),
        cmocka_unit_test(slopes_and_edges_are_no_levels),
        cmocka_unit_test(noise_waits_for_a_frame_that_tells),
        cmocka_unit_test(bad_parameters_are_named),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
