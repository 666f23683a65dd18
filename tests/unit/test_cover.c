/* The array that covers a scan's field of view: its outermost directions, orientation and seam. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "core/base/trig.h"
#include "core/grid/cover.h"
#include "core/grid/represent.h"

#include <errno.h>
#include <math.h>
#include <string.h>

static struct dx_geometry *spinning(uint32_t height, uint32_t width, double azimuth0_deg,
                                    double azimuth_deg, double elevation0_deg, double elevation_deg)
{
    struct dx_geometry *g;

    assert_int_equal(dx_geometry_new_spinning(&g, height, width, dx_rad(azimuth0_deg),
                                              dx_rad(azimuth_deg), dx_rad(elevation0_deg),
                                              dx_rad(elevation_deg)),
                     0);
    return g;
}

/* The same directions as a table. */
static struct dx_geometry *table_of(const struct dx_geometry *g)
{
    struct dx_geometry *t;

    assert_int_equal(dx_geometry_new(&t, DX_MODEL_TABLE, g->height, g->width), 0);
    for (uint32_t i = 0; i < g->height; i++)
        for (uint32_t j = 0; j < g->width; j++) {
            double d[3];

            dx_geometry_direction(g, i, j, d);
            for (int k = 0; k < 3; k++)
                t->table[3 * ((size_t)i * g->width + j) + (size_t)k] = (float)d[k];
        }
    t->wrap = g->wrap;
    dx_geometry_orient(t);
    return t;
}

static double apart(const struct dx_geometry *a, uint32_t row_a, uint32_t col_a,
                    const struct dx_geometry *b, uint32_t row_b, uint32_t col_b)
{
    double x[3], y[3], d2 = 0;

    dx_geometry_direction(a, row_a, col_a, x);
    dx_geometry_direction(b, row_b, col_b, y);
    for (int k = 0; k < 3; k++)
        d2 += (x[k] - y[k]) * (x[k] - y[k]);
    return sqrt(d2);
}

/* Checks the cover of `g` (NULL is freed) at its own size and at a smaller one. */
static void check_cover(struct dx_geometry *g, const struct dx_geometry *even)
{
    uint32_t h = g->height / 3, w = g->width / 3;
    struct dx_geometry *same, *small;
    struct dx_err err;

    g->unit_m = 0.002f;
    g->range_bytes = 4;
    g->pose[3] = 5;
    assert_int_equal(dx_cover_geometry(&same, g, g->height, g->width, &err), 0);
    assert_true(dx_geometry_departure(same, even) < 1e-3);
    assert_int_equal(same->flip, even->flip);
    assert_true(same->unit_m == 0.002f && same->range_bytes == 4 && same->pose[3] == 5);
    dx_geometry_unref(same);

    assert_int_equal(dx_cover_geometry(&small, g, h, w, &err), 0);
    assert_int_equal(small->wrap, even->wrap);
    assert_int_equal(small->flip, even->flip);
    assert_true(apart(small, 0, 0, g, 0, 0) < 1e-5);
    assert_true(apart(small, h - 1, 0, g, g->height - 1, 0) < 1e-5);
    if (!g->wrap)
        assert_true(apart(small, h - 1, w - 1, g, g->height - 1, g->width - 1) < 1e-5);
    dx_geometry_unref(small);
}

static void views_are_covered(void **state)
{
    struct dx_geometry *scans[] = {
        spinning(60, 120, 10, 3, -40, 1.5),    /* a full turn */
        spinning(60, 120, -70, -3, 30, -1),    /* the other way round */
        spinning(60, 100, 120, 1.5, -20, 0.5), /* across 180 degrees */
        spinning(60, 240, 7, -1.45, 20, -0.5), /* nearly a turn: open */
        spinning(90, 120, 0, 3, -89, 2),       /* to the poles */
    };

    (void)state;
    for (size_t k = 0; k < sizeof(scans) / sizeof(scans[0]); k++) {
        struct dx_geometry *table = table_of(scans[k]);

        check_cover(scans[k], scans[k]);
        check_cover(table, scans[k]);
        dx_geometry_unref(table);
        dx_geometry_unref(scans[k]);
    }
}

static void a_pinhole_stays_one(void **state)
{
    struct dx_geometry *g;

    (void)state;
    assert_int_equal(dx_geometry_new_pinhole(&g, 60, 90, 80, -85, 40, 31), 0);
    check_cover(g, g);
    dx_geometry_unref(g);
}

/* A full turn whose seam is said to be open: no direction falls between the columns. */
static void an_open_turn_is_covered_whole(void **state)
{
    struct dx_geometry *g = spinning(4, 360, 0, 1, -2, 1), *cover;
    struct dx_represent *r;
    struct dx_err err;

    (void)state;
    g->wrap = false;
    assert_int_equal(dx_cover_geometry(&cover, g, 4, 90, &err), 0);
    assert_false(cover->wrap);
    assert_int_equal(dx_represent_new(&r, cover, DX_KEEP_FIRST, 4000), 0);
    for (uint32_t k = 0; k < 1000; k++) {
        double a = k * 0.0063, p[3] = {dx_cos(a), dx_sin(a), 0};

        assert_int_equal(dx_represent_add(r, &(struct dx_samples){.n = 1, .xyz = p, .number = k}),
                         0);
    }
    assert_int_equal(dx_represent_counts(r)->taken, 1000);
    dx_represent_free(r);
    dx_geometry_unref(cover);
    dx_geometry_unref(g);
}

static void what_cannot_be_is_refused(void **state)
{
    struct dx_geometry *g = spinning(4, 30, 0, 1, -2, 1), *flat = table_of(g), *cover;
    struct dx_err err;

    (void)state;
    assert_int_equal(dx_cover_geometry(&cover, g, 1, 30, &err), -EINVAL);
    assert_non_null(strstr(err.text, "30x1"));
    assert_int_equal(dx_cover_geometry(&cover, g, 30, 1, &err), -EINVAL);
    assert_int_equal(dx_cover_geometry(&cover, g, 65536, 30, &err), -EINVAL);
    for (size_t k = 3; k < flat->n_table; k++) /* one direction everywhere */
        flat->table[k] = flat->table[k - 3];
    assert_int_equal(dx_cover_geometry(&cover, flat, 4, 30, &err), -EINVAL);
    assert_non_null(strstr(err.text, "field of view"));
    dx_geometry_unref(flat);
    dx_geometry_unref(g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(views_are_covered),
        cmocka_unit_test(a_pinhole_stays_one),
        cmocka_unit_test(an_open_turn_is_covered_whole),
        cmocka_unit_test(what_cannot_be_is_refused),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
