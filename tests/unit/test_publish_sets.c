/*
 * What is published does not depend on how: every instruction set and any number of threads leave
 * the same array, whichever filter, over frames in which dexels stand still, move, go and come back
 * (T6 and T8 of docs/terrain.md, before the mesh).
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "core/base/rng.h"
#include "core/grid/terrain.h"

#include <stdlib.h>

/* More rows of tiles than a caller takes alone, and a last column that is no whole block. */
#define HEIGHT   640
#define WIDTH    165
#define N_FRAMES 6

/* Where a dexel is and how much it shakes; some jump, some are missing for a while. */
static uint32_t any_range(struct dx_rng *rng, uint32_t before, uint8_t range_bytes)
{
    const uint32_t farthest = range_bytes == 2 ? UINT16_MAX : UINT32_MAX;

    switch (dx_rng_below(rng, 24)) {
    case 0:
        return 0;
    case 1:
        return 1 + dx_rng_below(rng, farthest);
    case 2:
        return farthest - dx_rng_below(rng, 4);
    case 3:
        return 1 + dx_rng_below(rng, 4);
    default:
        before = before ? before : 1000 + dx_rng_below(rng, 60000);
        return before > 20 && before < farthest - 20 ? before + dx_rng_below(rng, 19) - 9 : before;
    }
}

static void next_frame(struct dx_plane *p, struct dx_rng *rng)
{
    const bool still = dx_rng_below(rng, 3) == 0; /* the lower half is as it was */
    const size_t n = dx_plane_n_dexels(p) / (still ? 2 : 1);

    for (size_t k = 0; k < n; k++) {
        dx_plane_set_range(p, k, any_range(rng, dx_plane_range(p, k), p->range_bytes));
        dx_plane_set_attr(p, k, dx_rng_below(rng, 3));
    }
}

/* The same frames, taken by several terrains. */
struct bench {
    struct dx_geometry *geometry;
    struct dx_plane frame;
    struct dx_terrain_params params;
};

static void bench_init(struct bench *b, struct dx_rng *rng, enum dx_filter filter)
{
    const uint8_t range_bytes = dx_rng_below(rng, 3) ? 2 : 4;

    assert_int_equal(dx_geometry_new_spinning(&b->geometry, HEIGHT, WIDTH, 0, 0.005, -0.3, 0.001),
                     0);
    b->geometry->range_bytes = range_bytes;
    assert_int_equal(dx_plane_init(&b->frame, HEIGHT, WIDTH, range_bytes, 1), 0);
    dx_terrain_params_default(&b->params);
    b->params.ingest.filter = filter;
    b->params.ingest.hold = filter == DX_FILTER_OFF && dx_rng_below(rng, 2) ? 1.5 : -1;
    b->params.ingest.n_max = 1 + dx_rng_below(rng, 255);
    b->params.ingest.n_gap = dx_rng_below(rng, 3);
    b->params.ingest.keyframe = dx_rng_below(rng, 4);
    b->params.sigma_given = true;
    b->params.sigma[0] = 0.001 * (1 + dx_rng_below(rng, 8));
    b->params.sigma[1] = 1e-5 * dx_rng_below(rng, 100);
    b->params.sigma[2] = 1e-6 * dx_rng_below(rng, 1000);
}

static void bench_fini(struct bench *b)
{
    dx_plane_fini(&b->frame);
    dx_geometry_unref(b->geometry);
}

static struct dx_terrain *terrain_by(const struct bench *b, enum dx_simd simd)
{
    struct dx_terrain_params params = b->params;
    struct dx_terrain *t;

    params.simd = simd;
    assert_int_equal(dx_terrain_new(&t, b->geometry, &params, 1), 0);
    return t;
}

static void assert_same_array(const struct dx_terrain *x, const struct dx_terrain *y)
{
    const struct dx_plane *p = dx_terrain_published(x), *q = dx_terrain_published(y);

    assert_memory_equal(p->range, q->range, dx_plane_n_dexels(p) * p->range_bytes);
    assert_memory_equal(p->attr, q->attr, dx_plane_n_dexels(p));
}

/* In two parts; which tiles are due is decided by what is at hand, so others might publish less. */
static void publish(struct dx_terrain *t, const struct dx_plane *frame, uint32_t split,
                    struct dx_pool *pool)
{
    dx_terrain_publish(t, frame, split, WIDTH - split, pool);
    dx_terrain_publish(t, frame, 0, split, pool);
}

/* All frames through two terrains, the second on a pool. */
static void compare(struct bench *b, enum dx_simd x, enum dx_simd y, struct dx_pool *pool,
                    struct dx_rng rng)
{
    struct dx_terrain *want = terrain_by(b, x), *got = terrain_by(b, y);
    uint32_t n_changed = 0;

    dx_plane_clear(&b->frame);
    for (int k = 0; k < N_FRAMES; k++) {
        const uint32_t split = 1 + dx_rng_below(&rng, WIDTH - 1);

        next_frame(&b->frame, &rng);
        publish(want, &b->frame, split, NULL);
        publish(got, &b->frame, split, pool);
        assert_same_array(got, want);
        n_changed += dx_terrain_commit(want, NULL);
        dx_terrain_commit(got, pool);
    }
    assert_true(n_changed > 0);
    dx_terrain_free(got);
    dx_terrain_free(want);
}

static void every_set_and_pool_publishes_alike(void **state)
{
    const unsigned n_rounds = getenv("DEXEL_LONG") ? 200 : 3;
    struct dx_rng rng = dx_rng_init(21, 0);
    struct dx_pool *pool;

    (void)state;
    assert_int_equal(dx_pool_new(&pool, 3), 0);
    for (unsigned round = 0; round < n_rounds; round++)
        for (enum dx_filter filter = DX_FILTER_OFF; filter <= DX_FILTER_MEDIAN3; filter++) {
            struct bench b;

            bench_init(&b, &rng, filter);
            for (enum dx_simd simd = DX_SIMD_GENERIC; simd < DX_N_SIMD; simd++)
                if (dx_rows_get(simd))
                    compare(&b, DX_SIMD_GENERIC, simd, pool, dx_rng_init(22, round));
            bench_fini(&b);
        }
    dx_pool_free(pool);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_set_and_pool_publishes_alike),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
