/*
 * Smoothing over time (docs/terrain.md: T7 to T9): after every commit of any parts the published
 * array is the smoothed one of the samples so far, whatever the threads and the order; just the
 * tiles that differ are said to have changed; and a hold is over the samples.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "terrain_rig.h"

#define HEIGHT 135
#define WIDTH  200

struct sequence {
    struct dx_geometry *g;
    struct dx_terrain_params q;
    struct dx_plane frame, taken; /* as it changes, and what of it has been published */
    struct dx_terrain *t;
    struct dx_rng rng;
};

static void sequence_init(struct sequence *s, const struct variant *v, enum dx_scene scene)
{
    struct dx_scene_config c;

    rough_scene(&c, scene, HEIGHT, WIDTH);
    c.attr_bytes = 1;
    s->g = scene_frame(&c, &s->frame);
    assert_int_equal(dx_plane_init_for(&s->taken, s->g, 1), 0);
    dx_scene_cast(&s->taken, s->g, &c, 0, 0, WIDTH);
    use_variant(&s->q, v);
    s->q.smooth = s->q.sigma_given = true;
    s->q.sigma[0] = 0.005;
    s->t = meshed(s->g, &s->q, &s->frame, NULL);
    s->rng = dx_rng_init(11, (uint64_t)scene);
}

static void sequence_fini(struct sequence *s)
{
    dx_terrain_free(s->t);
    dx_plane_fini(&s->taken);
    dx_plane_fini(&s->frame);
    dx_geometry_unref(s->g);
}

/* Lost, or moved a little or far; every second one near the border of a tile. */
static void change_dexel(struct sequence *s)
{
    const bool near = dx_rng_below(&s->rng, 2);
    const uint32_t row = near ? 58 + dx_rng_below(&s->rng, 12) : dx_rng_below(&s->rng, HEIGHT);
    const uint32_t col =
        (near ? WIDTH - 8 + dx_rng_below(&s->rng, 16) + 64 * dx_rng_below(&s->rng, 3)
              : dx_rng_below(&s->rng, WIDTH)) %
        WIDTH;
    const size_t k = (size_t)row * WIDTH + col;
    const uint32_t range = dx_plane_range(&s->frame, k), kind = dx_rng_below(&s->rng, 4);

    dx_plane_set_range(&s->frame, k,
                       kind == 0   ? 0
                       : kind == 1 ? 1 + dx_rng_below(&s->rng, 9000)
                                   : (range ? range : 3000) + dx_rng_below(&s->rng, 30));
    if (kind == 3)
        dx_plane_set_attr(&s->frame, k, dx_rng_below(&s->rng, 256));
}

static void publish(struct sequence *s, uint32_t col0, uint32_t n)
{
    dx_terrain_publish(s->t, &s->frame, col0, n, NULL);
    for (uint32_t i = 0; i < HEIGHT; i++)
        for (uint32_t j = col0; j < col0 + n; j++) {
            const size_t k = (size_t)i * WIDTH + j;

            dx_plane_set_range(&s->taken, k, dx_plane_range(&s->frame, k));
            dx_plane_set_attr(&s->taken, k, dx_plane_attr(&s->frame, k));
        }
}

static uint64_t tile_hash(const struct dx_terrain *t, uint32_t k, struct dx_tile *tile)
{
    return dx_terrain_tile(t, k, tile) ? dx_tile_hash(tile) : 0;
}

static void assert_same_array(const struct dx_terrain *a, const struct dx_terrain *b)
{
    const struct dx_plane *p = dx_terrain_published(a), *q = dx_terrain_published(b);

    assert_memory_equal(p->range, q->range, dx_plane_n_dexels(p) * p->range_bytes);
    if (p->attr_bytes)
        assert_memory_equal(p->attr, q->attr, dx_plane_n_dexels(p) * p->attr_bytes);
}

/* `before`: of the tiles, before the commit. Returns how many changed. */
static uint32_t commit_and_check(struct sequence *s, const uint64_t *before)
{
    const uint32_t n_changed = dx_terrain_commit(s->t, NULL);
    struct dx_terrain *fresh = meshed(s->g, &s->q, &s->taken, NULL);
    struct dx_tile *tile = malloc(sizeof(*tile));
    uint32_t n = 0;

    assert_non_null(tile);
    assert_same_array(s->t, fresh);
    for (uint32_t k = 0; k < dx_tiling_n_tiles(dx_terrain_tiling(s->t)); k++) {
        const uint64_t now = tile_hash(s->t, k, tile);
        const bool changed = dx_terrain_changed(s->t)[k / 64] >> (k % 64) & 1;

        assert_int_equal(tile_hash(fresh, k, tile), now);
        assert_int_equal(changed, now != before[k]);
        n += changed;
    }
    assert_int_equal(n, n_changed);
    free(tile);
    dx_terrain_free(fresh);
    return n;
}

static uint32_t update(struct sequence *s, uint32_t n_parts, uint32_t n_dexels)
{
    struct dx_tile *tile = malloc(sizeof(*tile));
    uint64_t before[64] = {0};

    assert_non_null(tile);
    for (uint32_t k = 0; k < dx_tiling_n_tiles(dx_terrain_tiling(s->t)); k++)
        before[k] = tile_hash(s->t, k, tile);
    free(tile);
    for (; n_parts > 0; n_parts--) {
        const uint32_t col0 = dx_rng_below(&s->rng, WIDTH);

        for (uint32_t k = 0; k < n_dexels; k++)
            change_dexel(s);
        publish(s, col0, 1 + dx_rng_below(&s->rng, WIDTH - col0));
    }
    return commit_and_check(s, before);
}

static void updates_equal_from_scratch(void **state)
{
    static const enum dx_scene scenes[] = {DX_SCENE_HALL, DX_SCENE_MOVING_BOX};
    const int n = long_run() ? 500 : 6;
    uint32_t n_changed = 0;

    (void)state;
    for (int v = 0; v < N_VARIANTS; v += 2) {
        struct sequence s;

        sequence_init(&s, &variants[v], scenes[v / 2 % 2]);
        for (int k = 0; k < n; k++)
            n_changed += update(&s, 1, 2) + update(&s, 3, 20);
        sequence_fini(&s);
    }
    assert_true(n_changed > 100);
}

/* One dexel in the midst of a tile, two from its corner, from its side: as many tiles as it
 * reaches. */
static void a_dexel_changes_the_tiles_that_it_reaches(void **state)
{
    static const struct {
        uint32_t row, col, n_tiles;
    } cases[] = {{32, 32, 1}, {66, 65, 4}, {70, 70, 1}, {62, 100, 2}};

    (void)state;
    for (size_t c = 0; c < sizeof(cases) / sizeof(cases[0]); c++) {
        struct dx_terrain_params q;
        struct dx_geometry *g;
        struct dx_terrain *t;
        struct dx_plane p;

        assert_int_equal(dx_geometry_new_spinning(&g, HEIGHT, WIDTH, -0.5, 0.005, -0.3, 0.005), 0);
        assert_int_equal(dx_plane_init_for(&p, g, 0), 0);
        for (size_t k = 0; k < dx_plane_n_dexels(&p); k++)
            dx_plane_set_range(&p, k, 5000);
        dx_terrain_params_default(&q);
        q.smooth = q.sigma_given = true;
        q.rescue = false;
        q.diag = DX_DIAG_FIXED;
        q.sigma[0] = 0.05;
        t = meshed(g, &q, &p, NULL);
        dx_plane_set_range(&p, (size_t)cases[c].row * WIDTH + cases[c].col, 5100);
        dx_terrain_publish(t, &p, 0, WIDTH, NULL);
        assert_int_equal(dx_terrain_commit(t, NULL), cases[c].n_tiles);
        dx_terrain_publish(t, &p, 0, WIDTH, NULL);
        assert_int_equal(dx_terrain_commit(t, NULL), 0);
        dx_terrain_free(t);
        dx_plane_fini(&p);
        dx_geometry_unref(g);
    }
}

/* ---- threads and parts ---------------------------------------------------------------------- */

static void threads_and_parts_do_not_matter(void **state)
{
    static const unsigned threads[] = {1, 2, 3, 8};
    struct sequence s;

    (void)state;
    sequence_init(&s, &variants[4], DX_SCENE_OPEN);
    for (int k = 0; k < 4; k++) {
        struct dx_terrain *t;
        struct dx_pool *pool;

        assert_int_equal(dx_pool_new(&pool, threads[k]), 0);
        assert_int_equal(dx_terrain_new(&t, s.g, &s.q, 1), 0);
        for (uint32_t part = 0; part < WIDTH; part += 25) {
            const uint32_t col0 = (part + 25 * (uint32_t)k) % WIDTH;

            dx_terrain_publish(t, &s.frame, k & 1 ? col0 : WIDTH - 25 - col0, 25, NULL);
            if (part % 3 == 0)
                dx_terrain_commit(t, pool);
        }
        dx_terrain_commit(t, pool);
        assert_same_array(t, s.t);
        dx_terrain_free(t);
        dx_pool_free(pool);
    }
    sequence_fini(&s);
}

/* ---- with what comes before it -------------------------------------------------------------- */

/* What is held are the samples, as they are without smoothing; the smoothed array follows them. */
static void a_hold_is_over_the_samples(void **state)
{
    struct dx_terrain_params plain;
    struct dx_terrain *t, *held;
    struct dx_scene_config c;
    struct dx_geometry *g;
    struct dx_plane p;

    (void)state;
    rough_scene(&c, DX_SCENE_HALL, HEIGHT, WIDTH);
    g = scene_frame(&c, &p);
    dx_terrain_params_default(&plain);
    plain.ingest.filter = DX_FILTER_MEAN;
    plain.sigma_given = true;
    plain.sigma[0] = 0.005;
    assert_int_equal(dx_terrain_new(&held, g, &plain, c.attr_bytes), 0);
    plain.smooth = true;
    assert_int_equal(dx_terrain_new(&t, g, &plain, c.attr_bytes), 0);
    for (uint32_t frame = 0; frame < 6; frame++) {
        struct dx_terrain *fresh;

        dx_scene_cast(&p, g, &c, frame, 0, WIDTH);
        dx_terrain_publish(held, &p, 0, WIDTH, NULL);
        dx_terrain_publish(t, &p, 0, WIDTH, NULL);
        dx_terrain_commit(t, NULL);
        fresh = meshed(g, &plain, dx_terrain_published(held), NULL);
        assert_same_array(t, fresh);
        dx_terrain_free(fresh);
    }
    dx_terrain_free(t);
    dx_terrain_free(held);
    dx_plane_fini(&p);
    dx_geometry_unref(g);
}

/* The noise comes with a frame: everything is smoothed by it, also what was there before. */
static void the_noise_is_that_of_the_frame_that_tells_it(void **state)
{
    struct dx_terrain_params q;
    struct dx_terrain *t, *told;
    struct dx_scene_config c;
    struct dx_plane p, first;
    struct dx_geometry *g;

    (void)state;
    rough_scene(&c, DX_SCENE_HALL, HEIGHT, WIDTH);
    g = scene_frame(&c, &p);
    assert_int_equal(dx_plane_init_for(&first, g, c.attr_bytes), 0);
    for (uint32_t j = 0; j < 40; j++)
        dx_plane_set_range(&first, 50 * WIDTH + j, dx_plane_range(&p, 50 * WIDTH + j));
    dx_terrain_params_default(&q);
    q.smooth = true;
    t = meshed(g, &q, &first, NULL);
    assert_false(dx_terrain_params(t)->sigma_given); /* too few */
    dx_terrain_publish(t, &p, 0, WIDTH, NULL);
    dx_terrain_commit(t, NULL);
    assert_true(dx_terrain_params(t)->sigma_given);
    told = meshed(g, dx_terrain_params(t), &p, NULL);
    assert_same_array(t, told);
    dx_terrain_free(told);
    dx_terrain_free(t);
    dx_plane_fini(&first);
    dx_plane_fini(&p);
    dx_geometry_unref(g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(updates_equal_from_scratch),
        cmocka_unit_test(a_dexel_changes_the_tiles_that_it_reaches),
        cmocka_unit_test(threads_and_parts_do_not_matter),
        cmocka_unit_test(a_hold_is_over_the_samples),
        cmocka_unit_test(the_noise_is_that_of_the_frame_that_tells_it),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
