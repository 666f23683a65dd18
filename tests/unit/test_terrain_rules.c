/*
 * The rules of terrain mode as written, without the kernel: what the oracle makes of any mask, any
 * pattern of broken edges and any geometry keeps the invariants (docs/terrain.md: T2 to T5).
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "terrain_rig.h"

/* Share of the index plane that a mesh covers. */
static double covered(const struct whole_mesh *w, const struct dx_geometry *g)
{
    const uint32_t cols = g->wrap ? g->width : g->width - 1;
    double twice = 0;

    for (size_t k = 0; k < w->n; k++) {
        const struct flat f = flatten(&w->triangle[k], g);

        twice += (double)llabs(flat_area(&f));
    }
    return twice / 2 / ((g->height - 1) * (double)cols);
}

/* One distance all round, as the rules of struts alone see it. */
static struct dx_geometry *even_frame(struct dx_plane *p, struct dx_terrain_params *q,
                                      uint32_t height, uint32_t width, uint32_t range)
{
    struct dx_geometry *g;

    assert_int_equal(
        dx_geometry_new_spinning(&g, height, width, 0, 2 * DX_PI / width, -0.7, 1.4 / height), 0);
    assert_int_equal(dx_plane_init(p, height, width, 2, 0), 0);
    for (size_t k = 0; k < dx_plane_n_dexels(p); k++)
        dx_plane_set_range(p, k, range);
    dx_terrain_params_default(q);
    q->sigma_given = true;
    q->rescue = false;
    q->mixed = DX_MIXED_OFF;
    q->diag = DX_DIAG_FIXED;
    return g;
}

/* ALGORITHMS 1.5: drop-outs in percent, and the share covered with struts over 0, 1, 2 dexels. */
static void drop_outs_are_bridged(void **state)
{
    static const struct {
        uint32_t percent;
        double share[3];
    } bars[] = {{1, {0.975, 0.9999, 0.9999}},
                {5, {0.89, 0.997, 0.998}},
                {10, {0.78, 0.985, 0.987}},
                {20, {0.59, 0.91, 0.925}},
                {40, {0.25, 0.58, 0.65}}};
    struct dx_rng rng = dx_rng_init(15, 0);
    const uint32_t size = long_run() ? 600 : 120;

    (void)state;
    for (size_t n = 0; n < sizeof(bars) / sizeof(bars[0]); n++) {
        struct dx_terrain_params q;
        struct dx_plane p;
        struct dx_geometry *g = even_frame(&p, &q, size, size, 5000);

        for (size_t k = 0; k < dx_plane_n_dexels(&p); k++)
            if (dx_rng_below(&rng, 100) < bars[n].percent)
                dx_plane_set_range(&p, k, 0);
        for (q.bridge = 0; q.bridge <= 2; q.bridge++) {
            struct whole_mesh w = oracle_mesh_of(g, &p, &q);

            check_mesh(&w, g, &p);
            assert_true(covered(&w, g) >= bars[n].share[q.bridge]);
            free(w.triangle);
        }
        dx_plane_fini(&p);
        dx_geometry_unref(g);
    }
}

/* Dead rows and columns as wide as struts reach leave no hole; wider ones stay. */
static void dead_lines_are_closed(void **state)
{
    (void)state;
    for (int lines = 1; lines <= 3; lines++)
        for (int columns = 0; columns < 2; columns++) {
            struct dx_terrain_params q;
            struct dx_plane p;
            struct dx_geometry *g = even_frame(&p, &q, 24, 40, 5000);

            for (uint32_t i = 0; i < 24; i++)
                for (uint32_t j = 0; j < 40; j++) {
                    const uint32_t at = columns ? j : i;

                    if (at >= 7 && at < 7 + (uint32_t)lines)
                        dx_plane_set_range(&p, i * 40 + j, 0);
                }
            for (q.bridge = 0; q.bridge <= 2; q.bridge++) {
                struct whole_mesh w = oracle_mesh_of(g, &p, &q);

                check_mesh(&w, g, &p);
                assert_int_equal(covered(&w, g) > 0.99999, lines <= q.bridge);
                free(w.triangle);
            }
            dx_plane_fini(&p);
            dx_geometry_unref(g);
        }
}

/* Triangles of cells and of struts have sides that are edges, where those join neighbours: what is
 * not joined stays apart. Longer sides are struts and cuts. */
static void check_sides(const struct whole_mesh *w, const struct dx_geometry *g,
                        const struct dx_plane *p, const struct dx_terrain_params *q)
{
    struct oracle o;

    oracle_init(&o, g, p, q);
    for (size_t k = 0; k < w->n; k++) {
        const struct flat f = flatten(&w->triangle[k], g);

        for (int m = 0, n = 1; m < 3; m++, n = (n + 1) % 3)
            if (llabs(f.row[n] - f.row[m]) <= 1 && llabs(f.col[n] - f.col[m]) <= 1)
                assert_true(is_edge(&o, f.row[m], f.col[m], f.row[n], f.col[n]));
    }
    oracle_fini(&o);
}

/* Any rules on any small frame: every pattern of missing dexels and broken edges, at every border.
 */
static void any_frame_keeps_the_invariants(void **state)
{
    const int n = long_run() ? 200000 : 2500;
    struct dx_rng rng = dx_rng_init(16, 0);
    size_t n_triangles = 0, n_caps = 0;

    (void)state;
    for (int k = 0; k < n; k++) {
        const uint32_t side = k % 3 ? 10 : 40, height = 2 + dx_rng_below(&rng, side);
        struct dx_geometry *g =
            any_geometry(&rng, height, 2 + dx_rng_below(&rng, side), k & 1 ? 2 : 4);
        struct dx_terrain_params q;
        struct dx_plane p;
        struct whole_mesh w;
        unsigned caps;

        assert_int_equal(dx_plane_init(&p, g->height, g->width, g->range_bytes, 0), 0);
        any_frame(&p, &rng);
        any_rules(&q, &variants[dx_rng_below(&rng, N_VARIANTS)], &rng);
        q.caps = true;
        w = oracle_mesh_of(g, &p, &q);
        check_mesh(&w, g, &p);
        check_sides(&w, g, &p, &q);
        caps = oracle_caps(g, &p, &q);
        add_caps(&w, g, caps);
        check_closed(&w, g);
        n_triangles += w.n;
        n_caps += caps != 0;
        free(w.triangle);
        dx_plane_fini(&p);
        dx_geometry_unref(g);
    }
    assert_true(n_triangles > 50 * (size_t)n && n_caps > (size_t)n / 500);
}

/* Eight columns, a row on the horizon: between (0,3), (0,5) and (1,2) the scanner lies in the plane
 * of a bridge's triangle, and rounding would decide which way it looks. */
static void what_is_seen_edge_on_is_left_out(void **state)
{
    static const uint16_t range[16] = {0, 5000, 0,    5000, 0, 5000, 5000, 0, /* row 0 */
                                       0, 5000, 5000, 0,    0, 5000, 0,    0};
    struct dx_terrain_params q;
    struct dx_geometry *g;
    struct whole_mesh w;
    struct dx_plane p;

    (void)state;
    for (int turned = 0; turned < 64; turned++) {
        const int tenths = turned / 8;

        assert_int_equal(dx_geometry_new_spinning(&g, 2, 8, 0.1 * tenths, -DX_PI / 4, -0.5, 0.5),
                         0);
        assert_int_equal(dx_plane_init(&p, 2, 8, 2, 0), 0);
        for (uint32_t k = 0; k < 16; k++)
            dx_plane_set_range(&p, k, range[k / 8 * 8 + (k + (uint32_t)turned) % 8]);
        use_variant(&q, &variants[N_VARIANTS - 2]);
        q.sigma_given = true;
        q.mixed = DX_MIXED_OFF;
        w = oracle_mesh_of(g, &p, &q);
        check_mesh(&w, g, &p);
        free(w.triangle);
        dx_plane_fini(&p);
        dx_geometry_unref(g);
    }
}

/* Two caps make a full turn a sphere: no boundary, T = 2V - 4. */
static void caps_close_a_full_turn(void **state)
{
    struct dx_terrain_params q;
    struct dx_plane p;
    struct dx_geometry *g = even_frame(&p, &q, 24, 40, 5000);
    struct whole_mesh w;

    (void)state;
    q.caps = true;
    assert_int_equal(oracle_caps(g, &p, &q), 3);
    w = oracle_mesh_of(g, &p, &q);
    add_caps(&w, g, 3);
    check_closed(&w, g);
    assert_int_equal(w.n, 2 * 24 * 40 - 4);
    dx_plane_set_range(&p, 40 + 5, 0); /* the cells beside it keep their sides on the first row */
    assert_int_equal(oracle_caps(g, &p, &q), 3);
    dx_plane_set_range(&p, 40 + 6, 0); /* the cell between has lost it */
    assert_int_equal(oracle_caps(g, &p, &q), 2);
    free(w.triangle);
    dx_plane_fini(&p);
    dx_geometry_unref(g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(drop_outs_are_bridged),
        cmocka_unit_test(dead_lines_are_closed),
        cmocka_unit_test(any_frame_keeps_the_invariants),
        cmocka_unit_test(what_is_seen_edge_on_is_left_out),
        cmocka_unit_test(caps_close_a_full_turn),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
