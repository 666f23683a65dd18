/*
 * Terrain mode against its invariants (docs/terrain.md: T1-T5, T7, T13) on the simulated scenes,
 * and against an oracle that shares no code with it: the rules as written, cell by cell over the
 * whole frame.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "core/base/rng.h"
#include "core/base/trig.h"
#include "drivers/synth/scene.h"
#include "terrain_invariants.h"
#include "terrain_oracle.h"

#include <math.h>

static struct dx_geometry *scene(struct dx_scene_config *c, enum dx_scene s, struct dx_plane *p)
{
    struct dx_geometry *g;

    (void)s;
    assert_int_equal(dx_scene_geometry(&g, c), 0);
    assert_int_equal(dx_plane_init(p, g->height, g->width, g->range_bytes, c->attr_bytes), 0);
    dx_scene_cast(p, g, c, 0, 0, g->width);
    return g;
}

static struct dx_terrain *meshed(struct dx_geometry *g, const struct dx_terrain_params *params,
                                 const struct dx_plane *p, struct dx_pool *pool)
{
    struct dx_terrain *t;

    assert_int_equal(dx_terrain_new(&t, g, params, p->attr_bytes), 0);
    dx_terrain_publish(t, p, 0, p->width);
    dx_terrain_commit(t, pool);
    return t;
}

static void scenes_keep_the_invariants_and_match_the_oracle(void **state)
{
    (void)state;
    for (unsigned s = 0; s < DX_N_SCENES; s++)
        for (int variant = 0; variant < 4; variant++) {
            struct dx_terrain_params params;
            struct dx_scene_config c;
            struct dx_geometry *g;
            struct dx_terrain *t;
            struct dx_plane p;
            struct whole_mesh got, want;

            dx_scene_config_default(&c, (enum dx_scene)s);
            c.height = getenv("DEXEL_LONG") ? 1000 : 150; /* partial tiles at both ends */
            c.width = getenv("DEXEL_LONG") ? 1500 : 200;
            c.sigma[0] = 0.005;
            c.dropout = 0.03;
            c.mixed = 0.5;
            c.flip_rows = variant & 1;
            c.flip_cols = variant & 2;
            g = scene(&c, (enum dx_scene)s, &p);
            dx_terrain_params_default(&params);
            params.diag = variant == 3 ? DX_DIAG_FIXED : DX_DIAG_SHORT;
            t = meshed(g, &params, &p, NULL);
            check_invariants(t);
            got = collect(t);
            want = oracle_mesh(t);
            assert_true(got.n > 1000);
            assert_same_mesh(&got, &want);
            free(got.triangle);
            free(want.triangle);
            dx_terrain_free(t);
            dx_plane_fini(&p);
            dx_geometry_unref(g);
        }
}

/* T13 and the extremes: any bits are a frame. */
static void garbage_keeps_the_invariants(void **state)
{
    static const uint32_t extremes[] = {0, 1, 2, 65534, 65535, 1000, 1001};
    int n_rounds = getenv("DEXEL_LONG") ? 12000 : 20; /* of 9000 cells */
    struct dx_rng rng = dx_rng_init(13, 0);

    (void)state;
    for (int round = 0; round < n_rounds; round++) {
        struct dx_terrain_params params;
        struct dx_geometry *g;
        struct dx_terrain *t;
        struct dx_plane p;
        struct whole_mesh got, want;

        assert_int_equal(
            dx_geometry_new_spinning(&g, 70, 131, 0, (round & 1 ? 0.048 : 0.02), -0.6, 0.017), 0);
        assert_int_equal(dx_plane_init(&p, 70, 131, 2, 0), 0);
        for (size_t k = 0; k < dx_plane_n_dexels(&p); k++)
            dx_plane_set_range(&p, k,
                               dx_rng_below(&rng, 4)
                                   ? 60000 + dx_rng_below(&rng, 200u << (round % 6))
                                   : extremes[dx_rng_below(&rng, 7)]);
        dx_terrain_params_default(&params);
        params.sigma_given = round & 2;
        params.sigma[0] = 0.01;
        params.sigma[1] = 0.0001 * (round % 20);
        params.sigma[2] = 1e-6 * (round % 20);
        t = meshed(g, &params, &p, NULL);
        check_invariants(t);
        got = collect(t);
        want = oracle_mesh(t);
        assert_same_mesh(&got, &want);
        free(got.triangle);
        free(want.triangle);
        dx_terrain_free(t);
        dx_plane_fini(&p);
        dx_geometry_unref(g);
    }
}

/* T7: after every commit of any parts, the tiles are the mesh of the array; and only tiles that
 * differ are said to have changed. */
static void updates_equal_from_scratch(void **state)
{
    struct dx_rng rng = dx_rng_init(7, 0);
    struct dx_terrain_params params;
    struct dx_scene_config c;
    struct dx_terrain *t;
    struct dx_geometry *g;
    struct dx_plane p;
    uint64_t *before;
    uint32_t n_tiles;

    (void)state;
    dx_scene_config_default(&c, DX_SCENE_HALL);
    c.height = 150;
    c.width = 200;
    c.attr_bytes = 1;
    g = scene(&c, DX_SCENE_HALL, &p);
    dx_terrain_params_default(&params);
    t = meshed(g, &params, &p, NULL);
    n_tiles = dx_tiling_n_tiles(dx_terrain_tiling(t));
    before = calloc(n_tiles, sizeof(*before));
    struct dx_tile *tile = calloc(1, sizeof(*tile));
    for (int round = 0; round < 200; round++) {
        uint32_t col0 = dx_rng_below(&rng, c.width), n = 1 + dx_rng_below(&rng, c.width - col0);
        struct whole_mesh got, want;

        for (uint32_t k = 0; k < n_tiles; k++)
            before[k] = dx_terrain_tile(t, k, tile) ? dx_tile_hash(tile) : 0;
        for (uint32_t k = dx_rng_below(&rng, 30); k > 0; k--) {
            size_t at =
                (size_t)dx_rng_below(&rng, c.height) * c.width + dx_rng_below(&rng, c.width);

            dx_plane_set_range(&p, at, dx_rng_below(&rng, 3) ? 1 + dx_rng_below(&rng, 9000) : 0);
            dx_plane_set_attr(&p, at, dx_rng_below(&rng, 256));
        }
        dx_terrain_publish(t, &p, col0, n);
        dx_terrain_commit(t, NULL);
        for (uint32_t k = 0; k < n_tiles; k++) {
            uint64_t now = dx_terrain_tile(t, k, tile) ? dx_tile_hash(tile) : 0;

            assert_int_equal(dx_terrain_changed(t)[k / 64] >> (k % 64) & 1, now != before[k]);
        }
        got = collect(t);
        want = oracle_mesh(t);
        assert_same_mesh(&got, &want);
        free(got.triangle);
        free(want.triangle);
    }
    free(tile);
    free(before);
    dx_terrain_free(t);
    dx_plane_fini(&p);
    dx_geometry_unref(g);
}

/* T8: threads. Compilers and optimisation levels are compared by the golden digests of
 * tests/replay. */
static void threads_give_the_same_mesh(void **state)
{
    static const unsigned threads[] = {1, 2, 3, 8};
    struct dx_terrain_params params;
    struct dx_scene_config c;
    struct dx_geometry *g;
    struct dx_plane p;
    uint64_t first = 0;

    (void)state;
    dx_scene_config_default(&c, DX_SCENE_OPEN);
    c.sigma[0] = 0.01;
    g = scene(&c, DX_SCENE_OPEN, &p);
    dx_terrain_params_default(&params);
    for (int k = 0; k < 4; k++) {
        struct dx_terrain *t;
        struct dx_pool *pool;
        struct whole_mesh w;

        assert_int_equal(dx_pool_new(&pool, threads[k]), 0);
        t = meshed(g, &params, &p, pool);
        w = collect(t);
        first = k ? first : mesh_digest(&w);
        assert_int_equal(mesh_digest(&w), first);
        free(w.triangle);
        dx_terrain_free(t);
        dx_pool_free(pool);
    }
    dx_plane_fini(&p);
    dx_geometry_unref(g);
}

/* The 64-bit arithmetic decides as the 16-bit one. */
static void wide_equals_narrow(void **state)
{
    struct dx_terrain_params params;
    struct dx_scene_config c;
    struct dx_geometry *g, *g4;
    struct dx_plane p, p4;
    struct dx_terrain *t, *t4;
    struct whole_mesh w, w4;

    (void)state;
    dx_scene_config_default(&c, DX_SCENE_HALL);
    c.sigma[0] = 0.002;
    g = scene(&c, DX_SCENE_HALL, &p);
    assert_int_equal(dx_scene_geometry(&g4, &c), 0);
    g4->range_bytes = 4;
    assert_int_equal(dx_plane_init(&p4, g->height, g->width, 4, 0), 0);
    for (size_t k = 0; k < dx_plane_n_dexels(&p); k++)
        dx_plane_set_range(&p4, k, dx_plane_range(&p, k));
    dx_terrain_params_default(&params);
    t = meshed(g, &params, &p, NULL);
    t4 = meshed(g4, &params, &p4, NULL);
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

static void a_full_turn_closes_its_seam(void **state)
{
    struct dx_terrain_params params;
    struct dx_geometry *g;
    struct dx_terrain *t;
    struct dx_plane p;
    struct whole_mesh w;

    (void)state;
    assert_int_equal(dx_geometry_new_spinning(&g, 90, 130, 0.1, 2 * DX_PI / 130, -1.2, 2.4 / 90),
                     0);
    assert_true(g->wrap);
    assert_int_equal(dx_plane_init(&p, 90, 130, 2, 0), 0);
    for (size_t k = 0; k < dx_plane_n_dexels(&p); k++)
        dx_plane_set_range(&p, k, 5000);
    dx_terrain_params_default(&params);
    t = meshed(g, &params, &p, NULL);
    w = collect(t);
    assert_int_equal(w.n, 2 * 89 * 130);
    free(w.triangle);
    dx_terrain_free(t);
    dx_plane_fini(&p);
    dx_geometry_unref(g);
}

/* The paper's mode joins by length alone; the oracle is the distance of the points. */
static void the_cap_bounds_every_edge(void **state)
{
    struct dx_terrain_params params;
    struct dx_scene_config c;
    struct dx_geometry *g;
    struct dx_terrain *t;
    struct dx_plane p;
    struct whole_mesh w;
    size_t n_joined = 0;

    (void)state;
    for (int pinhole = 0; pinhole < 2; pinhole++) {
        dx_scene_config_default(&c, pinhole ? DX_SCENE_MOVING_BOX : DX_SCENE_HALL);
        g = scene(&c, c.scene, &p);
        dx_terrain_params_default(&params);
        params.paper = true;
        params.cap_m = pinhole ? 0.02 : 0.12;
        t = meshed(g, &params, &p, NULL);
        check_invariants(t);
        w = collect(t);
        n_joined += w.n;
        for (size_t k = 0; k < w.n; k++)
            for (int m = 0; m < 3; m++) {
                uint32_t a = w.triangle[k].v[m], b = w.triangle[k].v[(m + 1) % 3];
                float pa[3], pb[3];
                double d2 = 0;

                dx_geometry_point(g, a / g->width, a % g->width, dx_plane_range(&p, a), pa);
                dx_geometry_point(g, b / g->width, b % g->width, dx_plane_range(&p, b), pb);
                for (int x = 0; x < 3; x++)
                    d2 += ((double)pa[x] - (double)pb[x]) * ((double)pa[x] - (double)pb[x]);
                assert_true(sqrt(d2) <= params.cap_m + 2e-5);
            }
        free(w.triangle);
        dx_terrain_free(t);
        dx_plane_fini(&p);
        dx_geometry_unref(g);
    }
    assert_true(n_joined > 10000);
}

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
            g = scene(&c, c.scene, &p);
            dx_noise_estimate(sigma, &p, g);
            at5 = sigma[0] + sigma[2] * 25;
            assert_true(fabs(at5 - sigmas[k]) < 0.2 * sigmas[k]);
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
    struct whole_mesh got, want;
    double settled;

    (void)state;
    dx_scene_config_default(&c, DX_SCENE_HALL);
    c.sigma[0] = 0.01;
    g = scene(&c, c.scene, &p);
    assert_int_equal(dx_plane_init(&sparse, g->height, g->width, g->range_bytes, 0), 0);
    for (size_t k = 0; k < 600; k += 4)
        dx_plane_set_range(&sparse, k, 3000);
    dx_terrain_params_default(&params);
    t = meshed(g, &params, &sparse, NULL);
    assert_false(dx_terrain_params(t)->sigma_given);
    dx_terrain_publish(t, &p, 0, g->width);
    dx_terrain_commit(t, NULL);
    settled = dx_terrain_params(t)->sigma[0];
    assert_true(dx_terrain_params(t)->sigma_given && fabs(settled - 0.01) < 0.002);
    got = collect(t);
    want = oracle_mesh(t);
    assert_same_mesh(&got, &want);
    dx_terrain_publish(t, &sparse, 0, g->width);
    assert_true(dx_terrain_params(t)->sigma[0] == settled);
    free(got.triangle);
    free(want.triangle);
    dx_terrain_free(t);
    dx_plane_fini(&sparse);
    dx_plane_fini(&p);
    dx_geometry_unref(g);
}

/* A table whose directions fold over themselves in one place loses those cells and keeps its faces.
 */
static void folded_cells_are_masked(void **state)
{
    struct dx_terrain_params params;
    struct dx_geometry *g;
    struct dx_terrain *t;
    struct dx_plane p;
    struct whole_mesh w;

    (void)state;
    assert_int_equal(dx_geometry_new(&g, DX_MODEL_TABLE, 20, 20), 0);
    for (uint32_t i = 0; i < 20; i++)
        for (uint32_t j = 0; j < 20; j++) {
            double x = (j == 10 && i == 10 ? 12.5 : j) * 0.01 - 0.1, y = i * 0.01 - 0.1;
            double len = sqrt(x * x + y * y + 1);
            float *d = g->table + 3 * ((size_t)i * 20 + j);

            d[0] = (float)(x / len), d[1] = (float)(y / len), d[2] = (float)(1 / len);
        }
    dx_geometry_orient(g);
    assert_int_equal(dx_plane_init(&p, 20, 20, 2, 0), 0);
    for (size_t k = 0; k < 400; k++)
        dx_plane_set_range(&p, k, 1000);
    dx_terrain_params_default(&params);
    params.sigma_given = true;
    t = meshed(g, &params, &p, NULL);
    check_invariants(t);
    w = collect(t);
    assert_true(w.n > 2 * 19 * 19 - 16 && w.n < 2 * 19 * 19);
    free(w.triangle);
    dx_terrain_free(t);
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
        cmocka_unit_test(scenes_keep_the_invariants_and_match_the_oracle),
        cmocka_unit_test(garbage_keeps_the_invariants),
        cmocka_unit_test(updates_equal_from_scratch),
        cmocka_unit_test(threads_give_the_same_mesh),
        cmocka_unit_test(wide_equals_narrow),
        cmocka_unit_test(a_full_turn_closes_its_seam),
        cmocka_unit_test(the_cap_bounds_every_edge),
        cmocka_unit_test(noise_is_estimated_within_a_fifth),
        cmocka_unit_test(noise_waits_for_a_frame_that_tells),
        cmocka_unit_test(folded_cells_are_masked),
        cmocka_unit_test(bad_parameters_are_named),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
