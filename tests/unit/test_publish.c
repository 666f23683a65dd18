/*
 * From frames to the published array: the bound that a hold keeps (T12), tiles published together,
 * parts and whole frames, and that nothing of it changes what the mesh is: a pure function of the
 * array.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "core/base/rng.h"
#include "core/grid/estimator.h"
#include "publish_fixture.h"

/* ---- T12 ------------------------------------------------------------------------------------ */

/* The estimates beside, by an estimator of their own that gets the same parts. */
struct witness {
    struct dx_estimator e;
    struct dx_sigma sigma;
    uint64_t *estimate;
};

static void witness_init(struct witness *w, const struct rig *r, const struct dx_terrain_params *p)
{
    assert_int_equal(dx_estimator_init(&w->e, &p->ingest, &r->plane, dx_rows_get(DX_SIMD_AUTO)), 0);
    dx_sigma_init(&w->sigma, p->sigma, (double)r->g->unit_m);
    dx_estimator_settle(&w->e, &w->sigma);
    w->estimate = calloc(dx_plane_n_dexels(&r->plane), sizeof(*w->estimate));
    assert_non_null(w->estimate);
}

static void witness_take(struct witness *w, const struct rig *r, uint32_t col0, uint32_t n)
{
    struct dx_estimates out;

    dx_estimator_begin(&w->e, &r->plane, col0, n);
    for (uint32_t i = 0; i < r->g->height; i++)
        for (uint32_t col = col0, some; col < col0 + n; col += some) {
            some = col0 + n - col < DX_ESTIMATES ? col0 + n - col : DX_ESTIMATES;
            dx_estimator_take(&w->e, &r->plane, i, col, some, &out);
            for (uint32_t k = 0; k < some; k++)
                w->estimate[(size_t)i * r->g->width + col + k] = dx_estimate_at(&out, k);
        }
}

static void witness_fini(struct witness *w)
{
    dx_estimator_fini(&w->e);
    free(w->estimate);
}

/* How many dexels are not what they are estimated to be, all of them within the bound. */
static size_t assert_bound(const struct witness *w, const struct dx_plane *published, double hold)
{
    size_t n_held = 0;

    for (size_t k = 0; k < dx_plane_n_dexels(published); k++) {
        uint32_t range = dx_plane_range(published, k);
        double d = (double)w->estimate[k] - 256.0 * range;
        double bound = hold * dx_sigma_at(&w->sigma, range);

        assert_int_equal(range != 0, w->estimate[k] != 0);
        assert_true(d * d <= (bound > 128 ? bound * bound : 128 * 128));
        n_held += (w->estimate[k] + 128) / 256 != range;
    }
    return n_held;
}

/* What was published tile by tile is, meshed at once, the same mesh. */
static void assert_pure(const struct dx_terrain *t)
{
    const struct dx_plane *published = dx_terrain_published(t);
    struct dx_terrain_params p = *dx_terrain_params(t);
    struct whole_mesh got = collect(t), want;
    struct dx_terrain *fresh;

    p.ingest = (struct dx_ingest_params){.filter = DX_FILTER_OFF};
    assert_int_equal(dx_terrain_new(&fresh, (struct dx_geometry *)dx_terrain_geometry(t), &p,
                                    published->attr_bytes),
                     0);
    dx_terrain_publish(fresh, published, 0, published->width, NULL);
    dx_terrain_commit(fresh, NULL);
    want = collect(fresh);
    assert_true(got.n > 1000);
    assert_int_equal(got.n, want.n);
    assert_memory_equal(got.triangle, want.triangle, got.n * sizeof(*got.triangle));
    free(got.triangle);
    free(want.triangle);
    dx_terrain_free(fresh);
}

static void check_hold(enum dx_scene scene, enum dx_filter filter, double hold, uint32_t part)
{
    struct dx_terrain_params params = params_of(filter, hold);
    size_t n_held = 0, n_changed = 0, n_commits = 0;
    struct dx_terrain *t;
    struct witness w;
    struct rig r;

    rig_init(&r, scene, 130, 200);
    r.config.sigma[0] = 0.005;
    r.config.dropout = 0.02;
    rig_open(&r);
    t = terrain_of(&r, &params);
    witness_init(&w, &r, &params);
    for (uint32_t frame = 0; frame < 12; frame++) {
        rig_cast(&r, frame);
        for (uint32_t col = 0; col < r.g->width; col += part) {
            uint32_t n = r.g->width - col < part ? r.g->width - col : part;

            witness_take(&w, &r, col, n);
            n_changed += commit_columns(t, &r, col, n);
            n_commits++;
            if (frame > 0) /* before, some columns have not come at all */
                n_held += assert_bound(&w, dx_terrain_published(t), hold);
        }
    }
    assert_true(n_held > 0 || hold < 1); /* something was held back, and something was not */
    assert_true(n_changed > 0 && n_commits > 0);
    assert_pure(t);
    witness_fini(&w);
    dx_terrain_free(t);
    rig_close(&r);
}

static void what_is_published_is_within_the_hold(void **state)
{
    (void)state;
    check_hold(DX_SCENE_HALL, DX_FILTER_MEAN, 1.5, 200);
    check_hold(DX_SCENE_HALL, DX_FILTER_MEAN, 3, 77);
    check_hold(DX_SCENE_HALL, DX_FILTER_MEDIAN3, 4, 200);
    check_hold(DX_SCENE_HALL, DX_FILTER_OFF, 8, 64);
    check_hold(DX_SCENE_MOVING_BOX, DX_FILTER_MEAN, 1.5, 50);
    check_hold(DX_SCENE_MOVING_BOX, DX_FILTER_MEAN, 0.01, 200);
}

/* Noise alone. */
static void a_still_scene_comes_to_rest(void **state)
{
    struct dx_terrain_params params = params_of(DX_FILTER_MEAN, -1);
    struct dx_terrain *t;
    struct rig r;
    uint32_t n_changed = 0, n_tiles;

    (void)state;
    still_hall(&r, 130, 200);
    r.config.dropout = 0;
    t = terrain_of(&r, &params);
    n_tiles = dx_tiling_n_tiles(dx_terrain_tiling(t));
    for (uint32_t frame = 0; frame < 40; frame++) {
        uint32_t n;

        rig_cast(&r, frame);
        n = commit_columns(t, &r, 0, r.g->width);
        n_changed += frame >= 20 ? n : 0;
    }
    assert_true(n_changed < 20 * n_tiles * 15 / 100); /* without a hold: all of them, always */
    dx_terrain_free(t);
    rig_close(&r);
}

/* ---- parts, threads, widths ----------------------------------------------------------------- */

/* Frames through one terrain in parts of `part` columns, `whole` in one. */
static void assert_parts_equal(const struct dx_terrain_params *params, uint32_t part)
{
    struct dx_terrain *whole, *parts;
    struct rig r;

    still_hall(&r, 130, 200);
    whole = terrain_of(&r, params);
    parts = terrain_of(&r, params);
    for (uint32_t frame = 0; frame < 12; frame++) {
        rig_cast(&r, frame);
        dx_terrain_publish(whole, &r.plane, 0, r.g->width, NULL);
        for (uint32_t col = 0; col < r.g->width; col += part)
            dx_terrain_publish(parts, &r.plane, col,
                               r.g->width - col < part ? r.g->width - col : part, NULL);
        assert_true(same(dx_terrain_published(whole), dx_terrain_published(parts)));
        dx_terrain_commit(whole, NULL);
        dx_terrain_commit(parts, NULL);
    }
    dx_terrain_free(whole);
    dx_terrain_free(parts);
    rig_close(&r);
}

static void parts_give_what_a_whole_frame_gives(void **state)
{
    (void)state;
    for (enum dx_filter filter = DX_FILTER_OFF; filter <= DX_FILTER_MEDIAN3; filter++) {
        struct dx_terrain_params held = params_of(filter, 1.5), plain = params_of(filter, 0);

        assert_parts_equal(&plain, 23); /* any parts, where nothing is held */
        assert_parts_equal(&held, 64);  /* whole tiles, where tiles are held */
    }
}

/* Without a filter and a hold the array is the newest frame, byte for byte; a mean of one frame and
 * no gap is that, too. */
static void without_a_filter_the_array_is_the_frame(void **state)
{
    struct dx_terrain_params off = params_of(DX_FILTER_OFF, -1), one = params_of(DX_FILTER_MEAN, 0);
    struct dx_terrain *t, *t1;
    struct rig r;

    (void)state;
    one.ingest.n_max = 1;
    one.ingest.n_gap = 0;
    still_hall(&r, 130, 200);
    t = terrain_of(&r, &off);
    t1 = terrain_of(&r, &one);
    for (uint32_t frame = 0; frame < 4; frame++) {
        const struct dx_plane *p1 = dx_terrain_published(t1);

        rig_cast(&r, frame);
        dx_terrain_publish(t, &r.plane, 0, 90, NULL);
        dx_terrain_publish(t, &r.plane, 90, 110, NULL);
        dx_terrain_publish(t1, &r.plane, 0, 200, NULL);
        assert_true(same(dx_terrain_published(t), &r.plane));
        assert_memory_equal(p1->range, r.plane.range, dx_plane_n_dexels(p1) * p1->range_bytes);
    }
    dx_terrain_free(t);
    dx_terrain_free(t1);
    rig_close(&r);
}

static void threads_change_nothing(void **state)
{
    static const unsigned threads[] = {1, 2, 8};
    struct dx_terrain_params params = params_of(DX_FILTER_MEAN, -1);
    uint64_t first = 0;
    struct rig r;

    (void)state;
    still_hall(&r, 130, 200);
    for (int k = 0; k < 3; k++) {
        struct dx_terrain *t = terrain_of(&r, &params);
        struct dx_pool *pool;
        uint64_t digest = 0;

        assert_int_equal(dx_pool_new(&pool, threads[k]), 0);
        for (uint32_t frame = 0; frame < 8; frame++) {
            struct whole_mesh w;

            rig_cast(&r, frame);
            dx_terrain_publish(t, &r.plane, 0, r.g->width, NULL);
            digest = dx_hash_u64(digest, dx_terrain_commit(t, pool));
            w = collect(t);
            digest = dx_hash_u64(digest, mesh_digest(&w));
            free(w.triangle);
        }
        first = k ? first : digest;
        assert_int_equal(digest, first);
        dx_pool_free(pool);
        dx_terrain_free(t);
    }
    rig_close(&r);
}

static void narrow_and_wide_publish_the_same(void **state)
{
    struct dx_terrain_params params = params_of(DX_FILTER_MEAN, -1);
    struct dx_rng rng = dx_rng_init(4, 0);
    struct dx_terrain *t, *t4;
    struct rig r, r4;

    (void)state;
    flat(&r, 2);
    flat(&r4, 4);
    t = terrain_of(&r, &params);
    t4 = terrain_of(&r4, &params);
    for (int frame = 0; frame < 12; frame++) {
        for (size_t k = 0; k < FLAT_HEIGHT * FLAT_WIDTH; k++) {
            uint32_t range = dx_rng_below(&rng, 50) ? 5000 + dx_rng_below(&rng, 20) : 0;

            dx_plane_set_range(&r.plane, k, range);
            dx_plane_set_range(&r4.plane, k, range);
        }
        assert_int_equal(commit_columns(t, &r, 0, FLAT_WIDTH),
                         commit_columns(t4, &r4, 0, FLAT_WIDTH));
        for (size_t k = 0; k < FLAT_HEIGHT * FLAT_WIDTH; k++)
            assert_int_equal(dx_plane_range(dx_terrain_published(t), k),
                             dx_plane_range(dx_terrain_published(t4), k));
    }
    dx_terrain_free(t);
    dx_terrain_free(t4);
    rig_close(&r);
    rig_close(&r4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_published_is_within_the_hold),
        cmocka_unit_test(a_still_scene_comes_to_rest),
        cmocka_unit_test(parts_give_what_a_whole_frame_gives),
        cmocka_unit_test(without_a_filter_the_array_is_the_frame),
        cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(narrow_and_wide_publish_the_same),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
