/*
 * The cap, where f32 cannot tell: edges as long as the cap to the last bits, directions of any
 * length, ranges of 32 bits. The oracle measures each edge in integers.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "rounds.h"
#include "terrain_rig.h"

/* The distance of two neighbours whose ranges are r, metres. */
static double chord(const struct dx_geometry *g, uint32_t i, bool down, uint32_t r)
{
    double a[3], b[3], d2 = 0;

    dx_geometry_direction(g, i, 0, a);
    dx_geometry_direction(g, down ? i + 1 : i, down ? 0 : 1, b);
    for (int k = 0; k < 3; k++) {
        const double za = g->model == DX_MODEL_PINHOLE ? a[2] : 1;
        const double zb = g->model == DX_MODEL_PINHOLE ? b[2] : 1;

        d2 += (a[k] / za - b[k] / zb) * (a[k] / za - b[k] / zb);
    }
    return sqrt(d2) * r * (double)g->unit_m;
}

static void fill(struct dx_plane *p, uint32_t range)
{
    for (size_t k = 0; k < dx_plane_n_dexels(p); k++)
        dx_plane_set_range(p, k, range);
}

/* Returns the number of triangles. */
static size_t check(struct dx_geometry *g, const struct dx_plane *p, double cap_m, bool paper)
{
    struct dx_terrain_params q;
    struct dx_terrain *t;
    size_t n;

    use_variant(&q, &variants[paper ? 3 : 7]);
    q.sigma_given = true;
    q.cap_m = cap_m;
    t = meshed(g, &q, p, NULL);
    n = assert_like_oracle(t);
    dx_terrain_free(t);
    return n;
}

/* A sphere around the scanner: edges of a row have one length but for rounding, which is the cap.
 */
static void edges_as_long_as_the_cap_are_told_by_integers(void **state)
{
    struct dx_rng rng = dx_rng_init(41, 0);
    size_t n_triangles = 0;

    (void)state;
    for (int k = 0; k < ROUNDS(300); k++) {
        struct dx_geometry *g = any_geometry(&rng, 2 + dx_rng_below(&rng, 20),
                                             2 + dx_rng_below(&rng, 90), k & 1 ? 2 : 4);
        const uint32_t range = 100 + dx_rng_below(&rng, k & 1 ? 65000 : 20000000);
        const uint32_t row = dx_rng_below(&rng, g->height - 1);
        struct dx_plane p;

        assert_int_equal(dx_plane_init(&p, g->height, g->width, g->range_bytes, 0), 0);
        fill(&p, range);
        n_triangles += check(g, &p, chord(g, row, k & 2, range), k & 4);
        dx_plane_fini(&p);
        dx_geometry_unref(g);
    }
    assert_true(n_triangles > OF_ROUNDS(10000u, 500u));
}

/* Directions of lengths whose squares f32 holds, and not. */
static void beams_of_any_length_are_measured(void **state)
{
    static const float lengths[] = {1, 1e-3f, 1e3f, 1e-20f, 1e20f};
    struct dx_rng rng = dx_rng_init(41, 1);
    size_t n_triangles = 0;

    (void)state;
    for (int k = 0; k < ROUNDS(40); k++) {
        struct dx_geometry *g;
        struct dx_plane p;

        assert_int_equal(dx_geometry_new(&g, DX_MODEL_TABLE, 12, 70), 0);
        scatter_table(g, 0.01, 0.01, 0.3, &rng);
        for (size_t m = 0; m < g->n_table; m++)
            g->table[m] *= lengths[k % 5];
        assert_int_equal(dx_plane_init(&p, 12, 70, g->range_bytes, 0), 0);
        any_frame(&p, &rng);
        n_triangles += check(g, &p, 0.02 + dx_rng_unit(&rng), true);
        dx_plane_fini(&p);
        dx_geometry_unref(g);
    }
    assert_true(n_triangles > ROUNDS(3000));
}

/* Below what the fixed point holds it is still a cap. */
static void the_least_cap_joins_nothing(void **state)
{
    struct dx_terrain_params q;
    struct dx_scene_config c;
    struct whole_mesh mesh;
    struct dx_terrain *t;
    struct dx_plane p;
    struct dx_geometry *g;

    (void)state;
    rough_scene(&c, DX_SCENE_HALL, 20, 40);
    g = scene_frame(&c, &p);
    use_variant(&q, &variants[4]);
    q.cap_m = 1e-9;
    t = meshed(g, &q, &p, NULL);
    mesh = collect(t);
    assert_int_equal(mesh.n, 0);
    free(mesh.triangle);
    dx_terrain_free(t);
    dx_plane_fini(&p);
    dx_geometry_unref(g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_least_cap_joins_nothing),
        cmocka_unit_test(edges_as_long_as_the_cap_are_told_by_integers),
        cmocka_unit_test(beams_of_any_length_are_measured),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
