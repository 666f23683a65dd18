/*
 * Terrain mode over time (docs/terrain.md: T7, T9): after every commit of any parts, the tiles are
 * those of the array meshed from scratch, and just those that differ from before are said to have
 * changed.
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
    struct dx_plane frame, scene; /* as it changes, and as it was */
    struct dx_terrain *t;
    uint32_t n_tiles;
    uint64_t *before;
    struct dx_tile *tile, *other;
    struct dx_rng rng;
};

static void sequence_init(struct sequence *s, const struct variant *v, enum dx_scene scene)
{
    struct dx_scene_config c;

    rough_scene(&c, scene, HEIGHT, WIDTH);
    c.attr_bytes = 1;
    s->g = scene_frame(&c, &s->scene);
    assert_int_equal(dx_plane_init(&s->frame, HEIGHT, WIDTH, s->g->range_bytes, 1), 0);
    dx_scene_cast(&s->frame, s->g, &c, 0, 0, WIDTH);
    use_variant(&s->q, v);
    s->q.sigma_given = true;
    s->q.sigma[0] = 0.005;
    s->t = meshed(s->g, &s->q, &s->frame, NULL);
    s->n_tiles = dx_tiling_n_tiles(dx_terrain_tiling(s->t));
    s->before = calloc(s->n_tiles, sizeof(*s->before));
    s->tile = malloc(sizeof(*s->tile));
    s->other = malloc(sizeof(*s->other));
    assert_true(s->before && s->tile && s->other);
    s->rng = dx_rng_init(7, (uint64_t)scene);
}

static void sequence_fini(struct sequence *s)
{
    free(s->other);
    free(s->tile);
    free(s->before);
    dx_terrain_free(s->t);
    dx_plane_fini(&s->scene);
    dx_plane_fini(&s->frame);
    dx_geometry_unref(s->g);
}

/* Every second place is near the border of a tile, where what a change reaches belongs to another.
 */
static uint32_t any_place(struct dx_rng *rng, uint32_t n)
{
    const uint32_t border = DX_TILE_CELLS * dx_rng_below(rng, n / DX_TILE_CELLS + 1);

    return (dx_rng_below(rng, 2) ? dx_rng_below(rng, n) : border + n - 8 + dx_rng_below(rng, 16)) %
           n;
}

/* Lost, found again, moved a little or far. */
static void change_dexel(struct sequence *s, uint32_t row, uint32_t col)
{
    const size_t k = (size_t)row * WIDTH + col;
    const uint32_t was = dx_plane_range(&s->scene, k),
                   most = s->g->range_bytes == 2 ? 65535 : 200000;
    uint32_t range = 0;

    switch (dx_rng_below(&s->rng, 4)) {
    case 0:
        break;
    case 1:
        range = was;
        break;
    case 2:
        range = was + dx_rng_below(&s->rng, 60);
        break;
    default:
        range = 1 + dx_rng_below(&s->rng, 9000);
    }
    dx_plane_set_range(&s->frame, k, range < most ? range : most);
    dx_plane_set_attr(&s->frame, k, dx_rng_below(&s->rng, 256));
}

static void note_hashes(struct sequence *s)
{
    for (uint32_t k = 0; k < s->n_tiles; k++)
        s->before[k] = dx_terrain_tile(s->t, k, s->tile) ? dx_tile_hash(s->tile) : 0;
}

static void commit_and_check(struct sequence *s)
{
    const uint32_t n_changed = dx_terrain_commit(s->t, NULL);
    struct dx_terrain *fresh = meshed(s->g, &s->q, dx_terrain_published(s->t), NULL);
    uint32_t n = 0;

    for (uint32_t k = 0; k < s->n_tiles; k++) {
        const bool some = dx_terrain_tile(s->t, k, s->tile);
        const uint64_t now = some ? dx_tile_hash(s->tile) : 0;
        const bool changed = dx_terrain_changed(s->t)[k / 64] >> (k % 64) & 1;

        assert_int_equal(dx_terrain_tile(fresh, k, s->other), some);
        assert_int_equal(some ? dx_tile_hash(s->other) : 0, now);
        assert_memory_equal(s->tile->code, s->other->code, sizeof(s->tile->code));
        assert_int_equal(changed, now != s->before[k]);
        n += changed;
    }
    assert_int_equal(n, n_changed);
    dx_terrain_free(fresh);
}

/* One dexel a commit, published with as many columns around it as a packet has. */
static void update_dexels(struct sequence *s, int n)
{
    for (int k = 0; k < n; k++) {
        const uint32_t row = any_place(&s->rng, HEIGHT), col = any_place(&s->rng, WIDTH);
        const uint32_t n_cols = 1 + dx_rng_below(&s->rng, dx_rng_below(&s->rng, 2) ? 1 : 16);
        const uint32_t before = dx_rng_below(&s->rng, n_cols);
        const uint32_t col0 = col < before ? 0 : col - before;

        note_hashes(s);
        change_dexel(s, row, col);
        dx_terrain_publish(s->t, &s->frame, col0, col0 + n_cols < WIDTH ? n_cols : WIDTH - col0,
                           NULL);
        commit_and_check(s);
    }
}

/* Parts of columns, one or several a commit; dexels elsewhere have changed and are not published.
 */
static void update_columns(struct sequence *s, int n)
{
    for (int k = 0; k < n; k++) {
        note_hashes(s);
        for (uint32_t parts = 1 + dx_rng_below(&s->rng, 3); parts > 0; parts--) {
            const uint32_t col0 = dx_rng_below(&s->rng, WIDTH);

            for (uint32_t m = dx_rng_below(&s->rng, 30); m > 0; m--)
                change_dexel(s, any_place(&s->rng, HEIGHT), any_place(&s->rng, WIDTH));
            dx_terrain_publish(s->t, &s->frame, col0, 1 + dx_rng_below(&s->rng, WIDTH - col0),
                               NULL);
        }
        commit_and_check(s);
        if (k % 8 == 0)
            assert_like_oracle(s->t);
    }
}

static void updates_equal_from_scratch(void **state)
{
    static const enum dx_scene scenes[] = {DX_SCENE_HALL, DX_SCENE_OPEN, DX_SCENE_MOVING_BOX};
    const int n = long_run() ? 1000 : 240 / N_VARIANTS;

    (void)state;
    for (int v = 0; v < N_VARIANTS; v++) {
        struct sequence s;

        sequence_init(&s, &variants[v], scenes[v % 3]);
        update_dexels(&s, n);
        update_columns(&s, n / 4);
        assert_right(s.t);
        sequence_fini(&s);
    }
}

/* What is published twice has changed once. */
static void the_same_again_changes_nothing(void **state)
{
    (void)state;
    for (int v = 0; v < N_VARIANTS; v++) {
        struct sequence s;

        sequence_init(&s, &variants[v], DX_SCENE_STAIRS);
        dx_terrain_publish(s.t, &s.frame, 0, WIDTH, NULL);
        assert_int_equal(dx_terrain_commit(s.t, NULL), 0);
        assert_int_equal(dx_terrain_commit(s.t, NULL), 0);
        sequence_fini(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(updates_equal_from_scratch),
        cmocka_unit_test(the_same_again_changes_nothing),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
