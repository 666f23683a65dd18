/*
 * Terrain mode gives the same bytes whatever the threads, and whatever the order in which the parts
 * of a frame come (docs/terrain.md: T8). Compilers and optimisation levels are compared by the
 * golden digests of tests/replay.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "terrain_rig.h"

/* Everything that the tiles say, in the order of their numbers. */
static uint64_t tiles_digest(const struct dx_terrain *t)
{
    struct dx_tile *tile = malloc(sizeof(*tile));
    uint64_t digest = 0;

    assert_non_null(tile);
    for (uint32_t k = 0; k < dx_tiling_n_tiles(dx_terrain_tiling(t)); k++)
        digest = dx_hash_u64(digest, dx_terrain_tile(t, k, tile) ? dx_tile_hash(tile) : 0);
    free(tile);
    return digest;
}

static void threads_give_the_same_mesh(void **state)
{
    static const unsigned threads[] = {1, 2, 3, 8, 16};
    struct dx_scene_config c;
    struct dx_geometry *g;
    struct dx_plane p;

    (void)state;
    rough_scene(&c, DX_SCENE_OPEN, long_run() ? 1000 : 200, long_run() ? 1500 : 260);
    g = scene_frame(&c, &p);
    for (int v = 0; v < N_VARIANTS; v++) {
        uint64_t first = 0;

        for (int k = 0; k < 5; k++) {
            struct dx_terrain_params q;
            struct dx_terrain *t;
            struct dx_pool *pool;

            use_variant(&q, &variants[v]);
            assert_int_equal(dx_pool_new(&pool, threads[k]), 0);
            t = meshed(g, &q, &p, pool);
            first = k ? first : tiles_digest(t);
            assert_int_equal(tiles_digest(t), first);
            dx_terrain_free(t);
            dx_pool_free(pool);
        }
    }
    dx_plane_fini(&p);
    dx_geometry_unref(g);
}

static void shuffle(uint32_t *x, uint32_t n, struct dx_rng *rng)
{
    for (uint32_t k = n; k > 1; k--) {
        const uint32_t other = dx_rng_below(rng, k), swap = x[k - 1];

        x[k - 1] = x[other];
        x[other] = swap;
    }
}

/* A frame in parts of 16 columns, in any order, with a commit now and then. */
static void publish_shuffled(struct dx_terrain *t, const struct dx_plane *p, struct dx_rng *rng)
{
    uint32_t part[64], n = (p->width + 15) / 16;

    assert_true(n <= 64);
    for (uint32_t k = 0; k < n; k++)
        part[k] = k;
    shuffle(part, n, rng);
    for (uint32_t k = 0; k < n; k++) {
        const uint32_t col0 = 16 * part[k];

        dx_terrain_publish(t, p, col0, p->width - col0 < 16 ? p->width - col0 : 16, NULL);
        if (dx_rng_below(rng, 8) == 0)
            dx_terrain_commit(t, NULL);
    }
    dx_terrain_commit(t, NULL);
}

static void the_order_of_parts_does_not_matter(void **state)
{
    struct dx_rng rng = dx_rng_init(8, 0);
    struct dx_scene_config c;
    struct dx_geometry *g;
    struct dx_plane p;

    (void)state;
    rough_scene(&c, DX_SCENE_HALL, 140, 200);
    g = scene_frame(&c, &p);
    for (int v = 0; v < N_VARIANTS; v++) {
        struct dx_terrain_params q;
        struct dx_terrain *whole;

        use_variant(&q, &variants[v]);
        q.sigma_given = true;
        q.sigma[0] = 0.005;
        whole = meshed(g, &q, &p, NULL);
        for (int round = 0; round < 3; round++) {
            struct dx_terrain *t;

            assert_int_equal(dx_terrain_new(&t, g, &q, 0), 0);
            publish_shuffled(t, &p, &rng);
            assert_int_equal(tiles_digest(t), tiles_digest(whole));
            dx_terrain_free(t);
        }
        dx_terrain_free(whole);
    }
    dx_plane_fini(&p);
    dx_geometry_unref(g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_give_the_same_mesh),
        cmocka_unit_test(the_order_of_parts_does_not_matter),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
