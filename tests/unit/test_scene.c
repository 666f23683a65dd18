/* Analytic scenes: frames against the truth, their purity, noise shares, flips, golden digests. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "core/base/hash.h"
#include "tests/unit/scene_rig.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static uint64_t digest(const struct dx_plane *p)
{
    uint64_t h = 0;

    for (size_t k = 0; k < dx_plane_n_dexels(p); k++)
        h = dx_hash_u64(h, (uint64_t)dx_plane_range(p, k) << 16 | dx_plane_attr(p, k));
    return h;
}

static void names_go_both_ways(void **state)
{
    (void)state;
    for (unsigned k = 0; k < DX_N_SCENES; k++) {
        assert_int_equal(dx_scene_from_name(dx_scene_name(k)), k);
        assert_true(strlen(dx_scene_help(k)) > 0);
    }
    assert_null(dx_scene_name(DX_N_SCENES));
    assert_null(dx_scene_help(DX_N_SCENES));
    assert_int_equal(dx_scene_from_name("halls"), -1);
}

static void frames_are_the_truth(void **state)
{
    (void)state;
    for (unsigned scene = 0; scene < DX_N_SCENES; scene++) {
        struct rig r;

        rig_init(&r, scene, 90, 130);
        rig_open(&r);
        rig_cast(&r, 17);
        for (uint32_t i = 0; i < 90; i++)
            for (uint32_t j = 0; j < 130; j++) {
                double want = truth(&r, 17, i, j) / (double)r.g->unit_m;
                double got = dx_plane_range(&r.plane, (size_t)i * 130 + j);

                if (!(fabs(got - want) <= 0.5 + 1e-9))
                    fail_msg("%s (%u,%u): %g units, truth %g", dx_scene_name(scene), i, j, got,
                             want);
            }
        rig_close(&r);
    }
}

static double room_distance(const float p[3], const double lo[3], const double hi[3])
{
    double d = INFINITY;

    for (int k = 0; k < 3; k++) {
        double a = fabs((double)p[k] - lo[k]), b = fabs(hi[k] - (double)p[k]);

        d = fmin(d, fmin(a, b));
    }
    return d;
}

/* Points of the mesh lie on the surfaces: most of the hall's on its walls, floor and ceiling. */
static void points_lie_on_the_walls(void **state)
{
    const double lo[3] = {-9, -6, -1.5}, hi[3] = {7, 5, 2};
    uint32_t on_walls = 0;
    struct rig r;

    (void)state;
    rig_init(&r, DX_SCENE_HALL, 130, 200);
    rig_open(&r);
    assert_true(r.g->wrap);
    rig_cast(&r, 0);
    for (uint32_t i = 0; i < 130; i++)
        for (uint32_t j = 0; j < 200; j++) {
            float p[3];

            dx_geometry_point(r.g, i, j, dx_plane_range(&r.plane, i * 200 + j), p);
            on_walls += room_distance(p, lo, hi) < 0.001;
            for (int k = 0; k < 3; k++)
                assert_true((double)p[k] > lo[k] - 0.001 && (double)p[k] < hi[k] + 0.001);
        }
    assert_in_range(on_walls, 130 * 200 * 80 / 100, 130 * 200 * 97 / 100);
    rig_close(&r);
}

static void parts_and_order_do_not_matter(void **state)
{
    const uint32_t first[] = {101, 0, 64, 1, 65, 130};
    const uint32_t end[] = {130, 1, 65, 64, 101, 130};

    (void)state;
    for (unsigned scene = 0; scene < DX_N_SCENES; scene++) {
        struct rig whole, parts;

        rig_init(&whole, scene, 40, 130);
        whole.config.sigma[0] = 0.01;
        whole.config.dropout = whole.config.mixed = 0.2;
        parts = whole;
        rig_open(&whole);
        rig_open(&parts);
        rig_cast(&whole, 5);
        rig_cast(&parts, 4);
        assert_false(same(&whole.plane, &parts.plane));
        for (size_t k = 0; k < sizeof(first) / sizeof(first[0]); k++)
            dx_scene_cast(&parts.plane, parts.g, &parts.config, 5, first[k], end[k] - first[k]);
        assert_true(same(&whole.plane, &parts.plane));
        rig_close(&whole);
        rig_close(&parts);
    }
}

static void flips_mirror(void **state)
{
    (void)state;
    for (unsigned scene = 0; scene < DX_N_SCENES; scene++)
        for (int how = 1; how < 4; how++) {
            struct rig r, m;

            rig_init(&r, scene, 41, 60);
            m = r;
            m.config.flip_rows = how & 1;
            m.config.flip_cols = how & 2;
            rig_open(&r);
            rig_open(&m);
            assert_true((r.g->flip == m.g->flip) == (how == 3));
            rig_cast(&r, 3);
            rig_cast(&m, 3);
            for (uint32_t i = 0; i < 41; i++)
                for (uint32_t j = 0; j < 60; j++) {
                    uint32_t mi = how & 1 ? 40 - i : i, mj = how & 2 ? 59 - j : j;
                    size_t k = i * 60 + j, mk = mi * 60 + mj;

                    assert_int_equal(dx_plane_range(&r.plane, k), dx_plane_range(&m.plane, mk));
                    assert_int_equal(dx_plane_attr(&r.plane, k), dx_plane_attr(&m.plane, mk));
                }
            rig_close(&r);
            rig_close(&m);
        }
}

/* Deviations in units of the configured sigma have variance 1, at every range. */
static void noise_has_the_given_sigma(void **state)
{
    const double sigma[3] = {0.005, 0.002, 0.0005};
    double sum[2] = {0}, sum2[2] = {0}, n[2] = {0};
    struct rig r;

    (void)state;
    rig_init(&r, DX_SCENE_OPEN, 150, 300);
    memcpy(r.config.sigma, sigma, sizeof(sigma));
    rig_open(&r);
    rig_cast(&r, 2);
    for (uint32_t i = 0; i < 150; i++)
        for (uint32_t j = 0; j < 300; j++) {
            double want = truth(&r, 2, i, j);
            double off = dx_plane_range(&r.plane, i * 300 + j) * (double)r.g->unit_m - want;
            double z = off / (sigma[0] + sigma[1] * want + sigma[2] * want * want);
            int far = want > 20;

            sum[far] += z;
            sum2[far] += z * z;
            n[far] += 1;
        }
    for (int far = 0; far < 2; far++) {
        assert_true(n[far] > 4000);
        assert_true(fabs(sum[far] / n[far]) < 0.05);
        assert_true(fabs(sqrt(sum2[far] / n[far]) - 1) < 0.03);
    }
    rig_close(&r);
}

static void dropouts_have_their_share(void **state)
{
    uint32_t missing = 0, also_missing = 0, n = 200 * 300;
    struct rig r, other;

    (void)state;
    rig_init(&r, DX_SCENE_SPHERE, 200, 300);
    r.config.dropout = 0.1;
    other = r;
    other.config.seed = 2;
    rig_open(&r);
    rig_open(&other);
    rig_cast(&r, 0);
    rig_cast(&other, 0);
    for (size_t k = 0; k < n; k++) {
        bool gone = dx_plane_range(&r.plane, k) == 0;

        missing += gone;
        also_missing += gone && dx_plane_range(&other.plane, k) == 0;
        if (gone)
            assert_int_equal(dx_plane_attr(&r.plane, k), 0);
    }
    assert_in_range(missing, n * 94 / 1000, n * 106 / 1000);
    assert_in_range(also_missing, n * 8 / 1000, n * 12 / 1000);
    rig_close(&r);
    rig_close(&other);
}

static bool at_step(const struct rig *r, uint32_t i, uint32_t j, double *lo, double *hi)
{
    uint32_t w = r->g->width, h = r->g->height;
    double here = truth(r, 0, i, j);
    double around[4] = {truth(r, 0, i, (j + 1) % w), truth(r, 0, i, (j + w - 1) % w),
                        truth(r, 0, i ? i - 1 : i, j), truth(r, 0, i + 1 < h ? i + 1 : i, j)};
    bool step = false;

    *lo = *hi = here;
    for (int k = 0; k < 4; k++) {
        step |= fabs(around[k] - here) > 0.3;
        *lo = fmin(*lo, around[k]);
        *hi = fmax(*hi, around[k]);
    }
    return step;
}

static void mixed_pixels_stand_at_steps(void **state)
{
    uint32_t n_steps = 0, n_mixed = 0;
    struct rig r;

    (void)state;
    rig_init(&r, DX_SCENE_HALL, 200, 300);
    r.config.mixed = 0.7;
    rig_open(&r);
    rig_cast(&r, 0);
    for (uint32_t i = 0; i < 200; i++)
        for (uint32_t j = 0; j < 300; j++) {
            double got = dx_plane_range(&r.plane, i * 300 + j) * (double)r.g->unit_m, lo, hi;
            bool step = at_step(&r, i, j, &lo, &hi);
            bool moved = fabs(got - truth(&r, 0, i, j)) > 0.001;

            assert_true(got > lo - 0.001 && got < hi + 0.001);
            assert_true(step || !moved);
            n_steps += step;
            n_mixed += moved;
        }
    assert_true(n_steps > 1000);
    assert_in_range(n_mixed, n_steps * 65 / 100, n_steps * 75 / 100);
    rig_close(&r);
}

/* One setting does not change the draws of another. */
static void draws_are_apart(void **state)
{
    struct rig noisy, both;
    size_t n = 100 * 200;

    (void)state;
    rig_init(&noisy, DX_SCENE_HALL, 100, 200);
    noisy.config.sigma[0] = 0.01;
    both = noisy;
    both.config.dropout = 0.3;
    rig_open(&noisy);
    rig_open(&both);
    rig_cast(&noisy, 1);
    rig_cast(&both, 1);
    for (size_t k = 0; k < n; k++)
        if (dx_plane_range(&both.plane, k))
            assert_int_equal(dx_plane_range(&both.plane, k), dx_plane_range(&noisy.plane, k));
    rig_close(&noisy);
    rig_close(&both);
}

static void units_choose_the_width(void **state)
{
    struct rig r;

    (void)state;
    rig_init(&r, DX_SCENE_OPEN, 20, 40);
    rig_open(&r);
    assert_int_equal(r.g->range_bytes, 4); /* 80 m in millimetres */
    rig_close(&r);
    r.config.unit_m = 0.002;
    rig_open(&r);
    assert_int_equal(r.g->range_bytes, 2);
    rig_cast(&r, 0);
    assert_true(fabs(dx_plane_range(&r.plane, 0) * 0.002 - truth(&r, 0, 0, 0)) < 0.0011);
    rig_close(&r);
    r.config.unit_m = 0;
    rig_open(&r);
    assert_true(fabs((double)r.g->unit_m - 0.001) < 1e-9);
    rig_close(&r);
}

static void wrong_configurations_are_refused(void **state)
{
    struct dx_geometry *g = NULL;
    struct rig r;

    (void)state;
    rig_init(&r, DX_SCENE_HALL, 1, 100);
    assert_int_equal(dx_scene_geometry(&g, &r.config), -EINVAL);
    rig_init(&r, DX_SCENE_HALL, 100, 7);
    assert_int_equal(dx_scene_geometry(&g, &r.config), -EINVAL);
    rig_init(&r, DX_SCENE_HALL, 65535, 65535);
    assert_int_equal(dx_scene_geometry(&g, &r.config), -EINVAL);
    rig_init(&r, DX_SCENE_HALL, 100, 100);
    r.config.scene = DX_N_SCENES;
    assert_int_equal(dx_scene_geometry(&g, &r.config), -EINVAL);
    rig_init(&r, DX_SCENE_HALL, 100, 100);
    r.config.unit_m = NAN;
    assert_int_equal(dx_scene_geometry(&g, &r.config), -EINVAL);
    assert_null(g);
}

/* Machines, compilers and optimisation levels must agree on every dexel. */
static void digests_are_golden(void **state)
{
    static const uint64_t golden[DX_N_SCENES] = {
        0xee3b5db6c8553ad5, 0x4aada3641feb54fd, 0x71f3cb3ad91076f7, 0xeaece28c1820c32a,
        0x812dddcee4a98e31, 0x16c853238f252e33, 0xbd8835bbd5a1206b, 0x0081085d60f16525};

    (void)state;
    for (unsigned scene = 0; scene < DX_N_SCENES; scene++) {
        struct rig r;

        rig_init(&r, scene, 130, 200);
        r.config.sigma[0] = 0.002;
        r.config.sigma[2] = 0.0001;
        r.config.dropout = 0.01;
        r.config.mixed = 0.7;
        rig_open(&r);
        rig_cast(&r, 42);
        if (digest(&r.plane) != golden[scene])
            fail_msg("%s: digest is 0x%016llx", dx_scene_name(scene),
                     (unsigned long long)digest(&r.plane));
        rig_close(&r);
    }
}

/* A dexel's own direction, of any length, sees what the dexel sees. */
static void looks_are_the_truth(void **state)
{
    (void)state;
    for (unsigned scene = 0; scene < DX_N_SCENES; scene++) {
        struct rig r;

        rig_init(&r, scene, 30, 40);
        rig_open(&r);
        for (uint32_t i = 0; i < 30; i++)
            for (uint32_t j = 0; j < 40; j++) {
                double d[3], scaled[6], distance[2], want = truth(&r, 17, i, j);

                dx_geometry_direction(r.g, i, j, d);
                want /= r.g->model == DX_MODEL_PINHOLE ? d[2] : 1;
                for (int k = 0; k < 3; k++) {
                    scaled[k] = 3 * d[k];
                    scaled[3 + k] = d[k] / 7;
                }
                dx_scene_look(distance, scaled, 2, &r.config, 17);
                for (int k = 0; k < 2; k++)
                    assert_true(distance[k] == want || fabs(distance[k] - want) < 1e-5);
            }
        rig_close(&r);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_go_both_ways),
        cmocka_unit_test(frames_are_the_truth),
        cmocka_unit_test(looks_are_the_truth),
        cmocka_unit_test(points_lie_on_the_walls),
        cmocka_unit_test(parts_and_order_do_not_matter),
        cmocka_unit_test(flips_mirror),
        cmocka_unit_test(noise_has_the_given_sigma),
        cmocka_unit_test(dropouts_have_their_share),
        cmocka_unit_test(mixed_pixels_stand_at_steps),
        cmocka_unit_test(draws_are_apart),
        cmocka_unit_test(units_choose_the_width),
        cmocka_unit_test(wrong_configurations_are_refused),
        cmocka_unit_test(digests_are_golden),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
