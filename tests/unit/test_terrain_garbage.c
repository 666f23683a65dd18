/*
 * Terrain mode on frames that no scanner makes (docs/terrain.md: T13): any bits are a frame, under
 * any geometry and any parameters. The invariants, and the oracle's mesh.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "terrain_rig.h"

/* Small grids of every model, all rules, both widths of a range. */
static void any_frame_is_meshed_by_the_rules(void **state)
{
    const int n = long_run() ? 50000 : 700;
    struct dx_rng rng = dx_rng_init(13, 0);
    size_t n_triangles = 0;

    (void)state;
    for (int k = 0; k < n; k++) {
        const uint32_t side = k % 8 ? 12 : 100, height = 2 + dx_rng_below(&rng, side);
        struct dx_geometry *g =
            any_geometry(&rng, height, 2 + dx_rng_below(&rng, side), k & 1 ? 2 : 4);
        struct dx_terrain_params q;
        struct dx_terrain *t;
        struct dx_plane p;

        assert_int_equal(dx_plane_init(&p, g->height, g->width, g->range_bytes, 0), 0);
        any_frame(&p, &rng);
        any_rules(&q, &variants[dx_rng_below(&rng, (uint32_t)N_VARIANTS)], &rng);
        t = meshed(g, &q, &p, NULL);
        n_triangles += assert_right(t);
        dx_terrain_free(t);
        dx_plane_fini(&p);
        dx_geometry_unref(g);
    }
    assert_true(n_triangles > 20 * (size_t)n);
}

/* Ranges at the ends of what fits, ties, and a random rest about the farthest; a third of the
 * frames lets the noise be estimated from that. */
static void extreme_range(struct dx_plane *p, struct dx_rng *rng, uint32_t spread)
{
    static const uint32_t narrow[] = {0, 1, 2, 15, 16, 17, 65534, 65535, 1000, 1001};
    static const uint32_t broad[] = {0, 1, 15, 16, 65535, 65536, UINT32_MAX, UINT32_MAX - 1};
    const bool two = p->range_bytes == 2;
    const uint32_t base = two ? 60000 : 4000000000, n = two ? 10 : 8;

    for (size_t k = 0; k < dx_plane_n_dexels(p); k++)
        dx_plane_set_range(p, k,
                           dx_rng_below(rng, 4) ? base + dx_rng_below(rng, spread)
                           : two                ? narrow[dx_rng_below(rng, n)]
                                                : broad[dx_rng_below(rng, n)]);
}

static double any_of(struct dx_rng *rng, double most)
{
    static const double share[] = {0, 1e-6, 1e-4, 0.01, 0.3, 1};

    return most * share[dx_rng_below(rng, 6)];
}

static void extremes_keep_the_invariants(void **state)
{
    const int n_rounds = long_run() ? 12000 : 24; /* of 9000 cells */
    struct dx_rng rng = dx_rng_init(14, 0);

    (void)state;
    for (int round = 0; round < n_rounds; round++) {
        struct dx_geometry *g = any_geometry(&rng, 70, 131, round & 1 ? 2 : 4);
        struct dx_terrain_params q;
        struct dx_terrain *t;
        struct dx_plane p;

        g->unit_m = round % 3 ? 0.001f : 1e-6f;
        assert_int_equal(dx_plane_init(&p, 70, 131, g->range_bytes, 0), 0);
        extreme_range(&p, &rng, 200u << (round % 5));
        use_variant(&q, &variants[round % N_VARIANTS]);
        q.sigma_given = round % 3;
        q.sigma[0] = any_of(&rng, 1000);
        q.sigma[1] = any_of(&rng, 1000);
        q.sigma[2] = any_of(&rng, 1000);
        q.tilt_deg = any_of(&rng, 89);
        q.noise_k = any_of(&rng, 100);
        if (q.cap_m > 0)
            q.cap_m = 1e-6 + any_of(&rng, 1e5);
        assert_null(dx_terrain_params_check(&q));
        t = meshed(g, &q, &p, NULL);
        assert_right(t);
        dx_terrain_free(t);
        dx_plane_fini(&p);
        dx_geometry_unref(g);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_frame_is_meshed_by_the_rules),
        cmocka_unit_test(extremes_keep_the_invariants),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
