/* Terrain mode at the seam of a full turn, under a cap, and where directions fold. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "terrain_rig.h"

/* All at one distance. */
static void fill(struct dx_plane *p, const struct dx_geometry *g, uint32_t range)
{
    assert_int_equal(dx_plane_init(p, g->height, g->width, 2, 0), 0);
    for (size_t k = 0; k < dx_plane_n_dexels(p); k++)
        dx_plane_set_range(p, k, range);
}

static void a_full_turn_closes_its_seam(void **state)
{
    static const uint32_t widths[] = {8, 9, 63, 64, 65, 128};

    (void)state;
    for (int k = 0; k < 6; k++)
        for (int v = 0; v < N_VARIANTS; v++) {
            struct dx_terrain_params q;
            struct dx_geometry *g;
            struct dx_terrain *t;
            struct dx_plane p;

            assert_int_equal(dx_geometry_new_spinning(&g, 66, widths[k], 0.1, 2 * DX_PI / widths[k],
                                                      -1.2, 2.4 / 66),
                             0);
            assert_true(g->wrap);
            fill(&p, g, 5000);
            use_variant(&q, &variants[v]);
            if (q.cap_m > 0)
                q.cap_m = 10;
            t = meshed(g, &q, &p, NULL);
            assert_int_equal(assert_right(t), 2 * 65 * widths[k]);
            dx_terrain_free(t);
            dx_plane_fini(&p);
            dx_geometry_unref(g);
        }
}

/* Holes on either side of the seam and of the borders of tiles are meshed as holes elsewhere. */
static void holes_at_the_seam(void **state)
{
    struct dx_rng rng = dx_rng_init(17, 0);

    (void)state;
    for (int round = 0; round < 4 * N_VARIANTS; round++) {
        const uint32_t width = round & 1 ? 129 : 64 + 8;
        struct dx_terrain_params q;
        struct dx_geometry *g;
        struct dx_terrain *t;
        struct dx_plane p;

        assert_int_equal(
            dx_geometry_new_spinning(&g, 68, width, 0.1, 2 * DX_PI / width, -0.5, 1.0 / 68), 0);
        fill(&p, g, 5000);
        for (uint32_t i = 0; i < 68; i++)
            for (uint32_t j = 0; j < 9; j++)
                if (dx_rng_below(&rng, 3) == 0)
                    dx_plane_set_range(&p, i * width + (j + width - 5) % width, 0);
        for (uint32_t i = 61; i < 68; i++)
            for (uint32_t j = 0; j < width; j++)
                if (dx_rng_below(&rng, 4) == 0)
                    dx_plane_set_range(&p, i * width + j, 0);
        use_variant(&q, &variants[round % N_VARIANTS]);
        if (q.cap_m > 0)
            q.cap_m = 0.7;
        t = meshed(g, &q, &p, NULL);
        assert_true(assert_right(t) > 1000);
        dx_terrain_free(t);
        dx_plane_fini(&p);
        dx_geometry_unref(g);
    }
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
        g = scene_frame(&c, &p);
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
    fill(&p, g, 1000);
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_full_turn_closes_its_seam),
        cmocka_unit_test(holes_at_the_seam),
        cmocka_unit_test(the_cap_bounds_every_edge),
        cmocka_unit_test(folded_cells_are_masked),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
