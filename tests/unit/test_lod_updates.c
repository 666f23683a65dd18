/*
 * Levels of detail over time (docs/terrain.md): after every commit the tiles that a subscriber
 * holds, replaced as it is told, are those of the array cut from scratch, without a crack; and any
 * number of threads cuts the same.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "lod_rig.h"

#define HEIGHT 200

static const struct dx_lod_level levels[DX_LOD_SLOTS] = {
    {.bound = 24}, {.bound = 64}, {.stride = 16}, {.bound = 128, .stride = 32}};

struct sequence {
    struct dx_geometry *g;
    struct dx_terrain_params q;
    struct dx_plane frame;
    struct dx_terrain *t;
    struct dx_lod *lod;
    struct lod_tiles held[DX_LOD_SLOTS], fresh;
    struct dx_rng rng;
    uint64_t n_replaced, n_tiles;
};

static void take_changed(struct sequence *s)
{
    for (unsigned slot = 0; slot < DX_LOD_SLOTS; slot++)
        for (uint32_t n = 0; n < s->fresh.n_tiles; n++) {
            s->n_tiles++;
            if (!(dx_lod_changed(s->lod, slot)[n / 64] >> (n % 64) & 1))
                continue;
            s->n_replaced++;
            lod_tiles_set(&s->held[slot], s->lod, levels[slot], s->t, n);
        }
}

/* `width` of a full turn; smooth but for noise here and there, so that most of it is cut. */
static void sequence_init(struct sequence *s, uint32_t width, uint64_t seed)
{
    assert_int_equal(
        dx_geometry_new_spinning(&s->g, HEIGHT, width, 0, 2 * DX_PI / width, -0.6, 1.2 / HEIGHT),
        0);
    assert_int_equal(dx_plane_init_for(&s->frame, s->g, 0), 0);
    for (size_t k = 0; k < dx_plane_n_dexels(&s->frame); k++)
        dx_plane_set_range(&s->frame, k, 5000);
    dx_terrain_params_default(&s->q);
    s->q.sigma_given = true;
    s->q.sigma[0] = 0.004;
    s->t = meshed(s->g, &s->q, &s->frame, NULL);
    assert_int_equal(dx_lod_new(&s->lod, s->t, NULL), 0);
    for (unsigned slot = 0; slot < DX_LOD_SLOTS; slot++)
        lod_tiles_init(&s->held[slot], s->t);
    lod_tiles_init(&s->fresh, s->t);
    dx_lod_update(s->lod, levels, NULL);
    take_changed(s);
    s->rng = dx_rng_init(seed, 3);
    s->n_replaced = s->n_tiles = 0;
}

static void sequence_fini(struct sequence *s)
{
    lod_tiles_fini(&s->fresh);
    for (unsigned slot = 0; slot < DX_LOD_SLOTS; slot++)
        lod_tiles_fini(&s->held[slot]);
    dx_lod_free(s->lod);
    dx_terrain_free(s->t);
    dx_plane_fini(&s->frame);
    dx_geometry_unref(s->g);
}

static void check_held(struct sequence *s)
{
    struct dx_lod *lod;

    assert_int_equal(dx_lod_new(&lod, s->t, NULL), 0);
    dx_lod_update(lod, levels, NULL);
    for (unsigned slot = 0; slot < DX_LOD_SLOTS; slot++) {
        struct whole_mesh held = lod_union(&s->held[slot]), fresh;

        lod_tiles_set_all(&s->fresh, lod, levels[slot], s->t);
        fresh = lod_union(&s->fresh);
        assert_same_mesh(&held, &fresh);
        lod_check(&held, s->t);
        free(fresh.triangle);
        free(held.triangle);
    }
    dx_lod_free(lod);
}

/* Every second place is near a border of tiles. */
static uint32_t any_place(struct dx_rng *rng, uint32_t n)
{
    const uint32_t border = DX_TILE_CELLS * dx_rng_below(rng, n / DX_TILE_CELLS + 1);

    return (dx_rng_below(rng, 2) ? dx_rng_below(rng, n) : border + n - 4 + dx_rng_below(rng, 8)) %
           n;
}

static void change_some(struct sequence *s)
{
    const uint32_t width = s->g->width;

    for (uint32_t m = 1 + dx_rng_below(&s->rng, 3); m > 0; m--) {
        const uint32_t row = any_place(&s->rng, HEIGHT), col = any_place(&s->rng, width);
        const uint32_t kind = dx_rng_below(&s->rng, 4);
        const uint32_t range = kind == 0   ? 0
                               : kind == 1 ? 5000
                                           : 5000 + dx_rng_below(&s->rng, kind == 2 ? 60 : 3000);

        dx_plane_set_range(&s->frame, (size_t)row * width + col, range);
    }
    dx_terrain_publish(s->t, &s->frame, 0, width, NULL);
    dx_terrain_commit(s->t, NULL);
    dx_lod_note(s->lod, dx_terrain_changed(s->t));
}

static void updates_equal_from_scratch(uint32_t width, int n)
{
    struct sequence s = {0};

    sequence_init(&s, width, width);
    for (int k = 0; k < n; k++) {
        for (uint32_t commits = 1 + dx_rng_below(&s.rng, 2); commits > 0; commits--)
            change_some(&s); /* several commits may pass before a level is asked for */
        dx_lod_update(s.lod, levels, NULL);
        take_changed(&s);
        check_held(&s);
    }
    assert_true(s.n_replaced > 0 && s.n_replaced < s.n_tiles / 2);
    sequence_fini(&s);
}

static void updates_on_whole_tiles(void **state)
{
    (void)state;
    updates_equal_from_scratch(384, long_run() ? 400 : 6);
}

static void updates_over_a_seam_inside_a_tile(void **state)
{
    (void)state;
    updates_equal_from_scratch(360, long_run() ? 400 : 6);
}

static void nothing_new_is_nothing_to_send(void **state)
{
    struct sequence s = {0};

    (void)state;
    sequence_init(&s, 384, 1);
    dx_lod_update(s.lod, levels, NULL);
    take_changed(&s);
    assert_int_equal(s.n_replaced, 0);
    sequence_fini(&s);
}

static void threads_cut_the_same(void **state)
{
    static const unsigned threads[] = {1, 2, 3, 8};
    struct dx_terrain_params q;
    struct dx_scene_config c;
    struct dx_geometry *g;
    struct dx_terrain *t;
    struct dx_plane p;
    uint64_t first = 0;

    (void)state;
    rough_scene(&c, DX_SCENE_OPEN, HEIGHT, 400);
    c.dropout = 0.002;
    g = scene_frame(&c, &p);
    dx_terrain_params_default(&q);
    q.sigma_given = true;
    q.sigma[0] = 0.005;
    t = meshed(g, &q, &p, NULL);
    for (int k = 0; k < 4; k++) {
        struct dx_pool *pool;
        struct whole_mesh w;

        assert_int_equal(dx_pool_new(&pool, threads[k]), 0);
        w = lod_mesh_of(t, levels[1], pool);
        first = k ? first : mesh_digest(&w);
        assert_int_equal(mesh_digest(&w), first);
        free(w.triangle);
        dx_pool_free(pool);
    }
    dx_terrain_free(t);
    dx_plane_fini(&p);
    dx_geometry_unref(g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(updates_on_whole_tiles),
        cmocka_unit_test(updates_over_a_seam_inside_a_tile),
        cmocka_unit_test(nothing_new_is_nothing_to_send),
        cmocka_unit_test(threads_cut_the_same),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
