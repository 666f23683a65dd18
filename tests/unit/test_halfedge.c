/* Half-edges: what holds of them holds after every operation, drawn at random, many times. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "core/base/rng.h"
#include "halfedge_check.h"

static void expect_sound(const struct dx_halfedges *m)
{
    const char *wrong = halfedge_check(m);

    if (wrong)
        fail_msg("%s", wrong);
}

static void a_tetrahedron_closes(void **state)
{
    struct dx_halfedges m;
    struct halfedge_counts c;
    uint32_t b;

    (void)state;
    assert_int_equal(dx_halfedges_init(&m, 4), 0);
    assert_int_equal(dx_halfedges_add_triangle(&m, 0, 1, 2), 0);
    expect_sound(&m);
    b = dx_halfedge_find(&m, 1, 0);
    assert_true(dx_halfedge_is_border(&m, b));
    assert_true(dx_halfedge_fits(&m, b, 3, DX_NO_HALFEDGE)); /* a new point */
    assert_false(dx_halfedge_fits(&m, b, 0, DX_NO_HALFEDGE));
    assert_int_equal(dx_halfedges_glue(&m, b, 3, DX_NO_HALFEDGE), 0);
    expect_sound(&m);
    b = dx_halfedge_find(&m, 2, 1);
    assert_true(dx_halfedge_fits(&m, b, 3, DX_NO_HALFEDGE)); /* next to the edge */
    assert_int_equal(dx_halfedges_glue(&m, b, 3, DX_NO_HALFEDGE), 0);
    expect_sound(&m);
    b = dx_halfedge_find(&m, 0, 2);
    assert_int_equal(dx_halfedges_glue(&m, b, 3, DX_NO_HALFEDGE), 0); /* the hole is filled */
    expect_sound(&m);
    c = halfedge_count(&m);
    assert_int_equal(c.n_border, 0);
    assert_int_equal(c.euler, 2);
    assert_false(dx_halfedge_may_flip(&m, 0)); /* the other diagonal is there */
    dx_halfedges_fini(&m);
}

/* A point far along the border joins it to itself: two loops of one. */
static void a_border_is_parted_and_joined(void **state)
{
    struct dx_halfedges m;
    uint32_t b;

    (void)state;
    assert_int_equal(dx_halfedges_init(&m, 8), 0);
    assert_int_equal(dx_halfedges_add_triangle(&m, 0, 1, 2), 0);
    assert_int_equal(dx_halfedges_add_triangle(&m, 3, 4, 5), 0);
    assert_int_equal(halfedge_count(&m).n_loops, 2);
    b = dx_halfedge_find(&m, 1, 0);
    assert_int_equal(dx_halfedges_glue(&m, b, 3, dx_halfedge_corner(&m, 3)), 0);
    expect_sound(&m);
    assert_int_equal(halfedge_count(&m).n_loops, 1); /* components are one */
    assert_int_equal(halfedge_count(&m).n_corners, 1);
    b = dx_halfedge_find(&m, 2, 1);
    assert_true(dx_halfedge_fits(&m, b, 5, dx_halfedge_corner(&m, 5)));
    assert_int_equal(dx_halfedges_glue(&m, b, 5, dx_halfedge_corner(&m, 5)), 0);
    expect_sound(&m);
    assert_int_equal(halfedge_count(&m).n_loops, 2);
    dx_halfedges_fini(&m);
}

static int count_copy(void *ctx, uint32_t old, uint32_t made)
{
    assert_true(old < made);
    ++*(uint32_t *)ctx;
    return 0;
}

/* Any border half-edge with any point that fits. */
static void glue_any(struct dx_halfedges *m, struct dx_rng *g)
{
    const uint32_t b = dx_rng_below(g, m->n), q = dx_rng_below(g, m->n_vertices);
    uint32_t corner = dx_halfedge_corner(m, q);

    for (uint32_t turns = dx_rng_below(g, 4); corner != DX_NO_HALFEDGE && turns > 0; turns--)
        do
            corner = dx_halfedge_around(m, corner);
        while (!dx_halfedge_is_border(m, corner));
    if (dx_halfedge_fits(m, b, q, corner))
        assert_int_equal(dx_halfedges_glue(m, b, q, corner), 0);
}

static void change(struct dx_halfedges *m, struct dx_rng *g)
{
    const uint32_t what = dx_rng_below(g, 16), h = m->n ? dx_rng_below(g, m->n) : 0;
    uint32_t v, made = 0;

    if (m->n == 0 || what == 0) {
        const uint32_t a = dx_rng_below(g, m->n_vertices), b = (a + 1) % m->n_vertices,
                       c = (a + 2) % m->n_vertices;

        if (m->out[a] == DX_NO_HALFEDGE && m->out[b] == DX_NO_HALFEDGE &&
            m->out[c] == DX_NO_HALFEDGE)
            assert_int_equal(dx_halfedges_add_triangle(m, a, b, c), 0);
    } else if (what == 1) {
        assert_int_equal(dx_halfedges_add_vertex(m, &v), 0);
        assert_int_equal(dx_halfedges_split_edge(m, h, v), 0);
    } else if (what < 4) {
        if (dx_halfedge_may_flip(m, h))
            dx_halfedges_flip(m, h);
    } else if (what == 4 && dx_rng_below(g, 8) == 0) {
        const struct halfedge_counts before = halfedge_count(m);

        assert_int_equal(dx_halfedges_split_fans(m, count_copy, &made), 0);
        assert_int_equal(made, before.n_corners);
        assert_int_equal(halfedge_count(m).n_corners, 0);
    } else {
        glue_any(m, g);
    }
}

static void operations_keep_it_sound(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 300; seed++) {
        struct dx_rng g = dx_rng_init(seed, 11);
        struct dx_halfedges m;

        assert_int_equal(dx_halfedges_init(&m, 5 + dx_rng_below(&g, 20)), 0);
        for (int k = 0; k < 150; k++) {
            change(&m, &g);
            expect_sound(&m);
        }
        dx_halfedges_fini(&m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_tetrahedron_closes),
        cmocka_unit_test(a_border_is_parted_and_joined),
        cmocka_unit_test(operations_keep_it_sound),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
