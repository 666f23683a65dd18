/*
 * The kernel against the oracle that shares no code with it: any geometry, any rules, any pattern
 * of missing dexels and broken edges, in both widths of ranges.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "terrain_rig.h"

static void the_kernel_equals_the_oracle(void **state)
{
    const int n = long_run() ? 100000 : 600;
    struct dx_rng rng = dx_rng_init(17, 0);
    size_t n_triangles = 0;

    (void)state;
    for (int k = 0; k < n; k++) {
        const uint32_t side = k % 5 ? 12 : 150, height = 2 + dx_rng_below(&rng, side);
        struct dx_geometry *g =
            any_geometry(&rng, height, 2 + dx_rng_below(&rng, side), k & 1 ? 2 : 4);
        const int variant = (int)dx_rng_below(&rng, N_VARIANTS);
        struct dx_terrain_params q;
        struct whole_mesh got, want;
        struct dx_terrain *t;
        struct dx_plane p;

        assert_int_equal(dx_plane_init(&p, g->height, g->width, g->range_bytes, 0), 0);
        any_frame(&p, &rng);
        any_rules(&q, &variants[variant], &rng);
        q.caps = true;
        assert_int_equal(dx_terrain_new(&t, g, &q, 0), 0);
        dx_terrain_publish(t, &p, 0, p.width, NULL);
        dx_terrain_commit(t, NULL);
        got = collect(t);
        want = oracle_mesh_of(g, &p, &q);
        if (got.n != want.n || memcmp(got.triangle, want.triangle, got.n * sizeof(struct triangle)))
            fail_msg(
                "frame %d, variant %d: %u x %u, model %d, wrap %d: %zu triangles, expected %zu", k,
                variant, g->height, g->width, (int)g->model, g->wrap, got.n, want.n);
        assert_int_equal(dx_terrain_caps(t), oracle_caps(g, &p, &q));
        n_triangles += got.n;
        free(got.triangle);
        free(want.triangle);
        dx_terrain_free(t);
        dx_plane_fini(&p);
        dx_geometry_unref(g);
    }
    assert_true(n_triangles > 500 * (size_t)n);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_kernel_equals_the_oracle),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
