/*
 * Points to ranges, by parts of rows and point by point: the same ranges for every width, model and
 * instruction set, and a point that is off its beam is found in every column.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include "core/base/rng.h"
#include "core/grid/fit.h"
#include "core/rows/rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define HEIGHT    3
#define MAX_WIDTH 200

struct frame {
    struct dx_geometry *g;
    double xyz[3 * HEIGHT * MAX_WIDTH];
    uint16_t attr[HEIGHT * MAX_WIDTH];
    struct dx_points points;
};

static struct dx_geometry *make_geometry(enum dx_model model, uint32_t width, struct dx_rng *rng)
{
    struct dx_geometry *g = NULL;

    if (model == DX_MODEL_PINHOLE) {
        assert_int_equal(dx_geometry_new_pinhole(&g, HEIGHT, width, 90, 90, width / 2.0, 1), 0);
    } else {
        assert_int_equal(dx_geometry_new_spinning(&g, HEIGHT, width, -1, 0.01, -0.1, 0.1), 0);
        for (uint32_t row = 0; row < HEIGHT; row++) /* beams that do not begin at the scanner */
            for (int k = 3; k < 6; k++)
                g->table[2 * width + 6 * row + (uint32_t)k] = (float)dx_rng_unit(rng) * 0.1f;
    }
    g->unit_m = 0.001f;
    return g;
}

/* The directions of a spinning geometry, dexel by dexel. */
static struct dx_geometry *to_table(struct dx_geometry *g)
{
    struct dx_geometry *t = NULL;

    assert_int_equal(dx_geometry_new(&t, DX_MODEL_TABLE, g->height, g->width), 0);
    for (uint32_t k = 0; k < g->height * g->width; k++) {
        double d[3];

        dx_geometry_direction(g, k / g->width, k % g->width, d);
        for (uint32_t m = 0; m < 3; m++)
            t->table[3 * k + m] = (float)d[m];
    }
    t->unit_m = g->unit_m;
    t->range_bytes = g->range_bytes;
    dx_geometry_unref(g);
    return t;
}

/* A point on a dexel's beam as the scanner sees it, or something else. */
static void make_point(double p[3], const struct dx_geometry *g, uint32_t row, uint32_t col,
                       struct dx_rng *rng)
{
    static const double odd[] = {NAN,   INFINITY, -INFINITY, 0,       1e-13,
                                 1e300, 1e12,     -1,        65.5355, 5e-4};
    const uint32_t kind = dx_rng_below(rng, 10);
    double r = kind < 7 ? 0.1 + 60 * dx_rng_unit(rng) : 0.0005 * dx_rng_below(rng, 5);

    dx_geometry_direction(g, row, col, p);
    for (int k = 0; k < 3; k++) {
        p[k] *= r;
        if (kind == 8)
            p[k] = odd[dx_rng_below(rng, sizeof(odd) / sizeof(*odd))];
        if (kind == 9)
            p[k] = (double)(float)p[k];
    }
}

static void make_frame(struct frame *f, enum dx_model model, uint32_t width, struct dx_rng *rng)
{
    f->g = make_geometry(model == DX_MODEL_PINHOLE ? model : DX_MODEL_SPINNING, width, rng);
    if (model == DX_MODEL_TABLE)
        f->g = to_table(f->g);
    f->g->range_bytes = dx_rng_below(rng, 2) ? 2 : 4;
    for (uint32_t k = 0; k < HEIGHT * width; k++) {
        make_point(f->xyz + 3 * k, f->g, k / width, k % width, rng);
        f->attr[k] = (uint16_t)dx_rng_below(rng, 65536);
    }
    f->points = (struct dx_points){HEIGHT, width, f->xyz, f->attr, 2};
}

/* What fit.h says of one point. */
static uint32_t range_of(const struct frame *f, uint32_t k)
{
    const struct dx_geometry *g = f->g;
    const uint32_t row = k / g->width, col = k % g->width;
    double x = f->xyz[3 * k], y = f->xyz[3 * k + 1], z = f->xyz[3 * k + 2];

    if (!dx_fit_valid(f->xyz + 3 * k))
        return 0;
    if (g->model == DX_MODEL_PINHOLE)
        return dx_geometry_units(g, z);
    if (g->model == DX_MODEL_SPINNING) {
        const float *cs = g->table + 2 * col, *o = g->table + 2 * g->width + 6 * row + 3;
        const double c = (double)cs[0], s = (double)cs[1];

        x -= (double)o[0] * c - (double)o[1] * s;
        y -= (double)o[0] * s + (double)o[1] * c;
        z -= (double)o[2];
    }
    return dx_geometry_units(g, sqrt(x * x + y * y + z * z));
}

static void check_frame(const struct frame *f)
{
    struct dx_plane plane;
    uint32_t dropped = 0;

    assert_int_equal(dx_plane_init(&plane, HEIGHT, f->g->width, f->g->range_bytes, 2), 0);
    plane.xyz = calloc(dx_plane_n_dexels(&plane), 3 * sizeof(*plane.xyz));
    assert_non_null(plane.xyz);
    for (uint32_t k = 0; k < HEIGHT * f->g->width; k++) {
        const double *p = f->xyz + 3 * k;

        dropped += range_of(f, k) == 0 && !isnan(p[0]) && !isnan(p[1]) && !isnan(p[2]);
    }
    assert_int_equal(dx_fit_ranges(&plane, f->g, &f->points), dropped);
    for (uint32_t k = 0; k < HEIGHT * f->g->width; k++) {
        const uint32_t range = range_of(f, k);

        assert_int_equal(dx_plane_range(&plane, k), range);
        assert_int_equal(dx_plane_attr(&plane, k), range ? f->attr[k] : 0);
        for (uint32_t m = 3 * k; m < 3 * k + 3; m++)
            assert_true(plane.xyz[m] == (range ? (float)f->xyz[m] : 0));
    }
    dx_plane_fini(&plane);
}

static void every_width_is_as_point_by_point(void **state)
{
    static const uint32_t widths[] = {1, 63, 64, 65, 127, 128, MAX_WIDTH};
    struct frame *f = calloc(1, sizeof(*f));
    struct dx_rng rng = dx_rng_init(7, 1);

    (void)state;
    assert_non_null(f);
    for (uint32_t k = 0; k < 210; k++) {
        make_frame(f, (enum dx_model)(1 + k % 3), widths[k / 3 % 7], &rng);
        check_frame(f);
        dx_geometry_unref(f->g);
    }
    free(f);
}

static void a_point_that_is_off_is_found_in_every_column(void **state)
{
    struct frame *f = calloc(1, sizeof(*f));
    struct dx_rng rng = dx_rng_init(7, 2);

    (void)state;
    assert_non_null(f);
    for (uint32_t n = 0; n < 6; n++) {
        const uint32_t width = n / 3 ? 150 : 50;

        make_frame(f, (enum dx_model)(1 + n % 3), width, &rng);
        for (uint32_t k = 0; k < HEIGHT * width; k++) {
            dx_geometry_direction(f->g, k / width, k % width, f->xyz + 3 * k);
            for (uint32_t m = 3 * k; m < 3 * k + 3; m++)
                f->xyz[m] = k % 11 ? (double)(float)(7 * f->xyz[m]) : NAN;
        }
        assert_true(dx_fit_holds(f->g, &f->points, 0.5));
        for (uint32_t k = 0; k < HEIGHT * width; k++) {
            double *p = f->xyz + 3 * k, kept[3];

            memcpy(kept, p, sizeof(kept));
            dx_geometry_direction(f->g, (k / width + 1) % HEIGHT, k % width, p);
            for (int m = 0; m < 3; m++)
                p[m] *= 7;
            assert_false(dx_fit_holds(f->g, &f->points, 0.5));
            dx_geometry_direction(f->g, k / width, k % width, p);
            for (int m = 0; m < 3; m++)
                p[m] *= 5e7; /* more than 32 bits of millimetres */
            assert_false(dx_fit_holds(f->g, &f->points, 0.5));
            memcpy(p, kept, sizeof(kept));
        }
        dx_geometry_unref(f->g);
    }
    free(f);
}

static void every_set_measures_alike(void **state)
{
    const struct dx_rows *generic = dx_rows_get(DX_SIMD_GENERIC);
    struct frame *f = calloc(1, sizeof(*f));
    struct dx_rng rng = dx_rng_init(7, 3);

    (void)state;
    assert_non_null(f);
    for (uint32_t n = 0; n < 300; n++) {
        const float *t;
        struct dx_row_beams beams;
        uint32_t want[DX_ROWS_CELLS], got[DX_ROWS_CELLS];
        uint64_t dropped, on;

        make_frame(f, (enum dx_model)(1 + n % 3), DX_ROWS_CELLS, &rng);
        t = f->g->table;
        beams = (struct dx_row_beams){DX_BEAMS_TABLE, t, NULL};
        if (f->g->model == DX_MODEL_SPINNING)
            beams = (struct dx_row_beams){DX_BEAMS_SPINNING, t, t + 2 * DX_ROWS_CELLS};
        if (f->g->model == DX_MODEL_PINHOLE)
            beams = (struct dx_row_beams){DX_BEAMS_PINHOLE, t, t + DX_ROWS_CELLS};
        dropped = generic->units(want, f->xyz, &beams, (double)f->g->unit_m, 65535);
        on = generic->on_beams(f->xyz, &beams, 0.001, 65);
        for (enum dx_simd k = DX_SIMD_GENERIC + 1; k < DX_N_SIMD; k++) {
            const struct dx_rows *rows = dx_rows_get(k);

            if (!rows)
                continue;
            assert_true(rows->units(got, f->xyz, &beams, (double)f->g->unit_m, 65535) == dropped);
            assert_memory_equal(got, want, sizeof(want));
            assert_true(rows->on_beams(f->xyz, &beams, 0.001, 65) == on);
        }
        dx_geometry_unref(f->g);
    }
    free(f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_width_is_as_point_by_point),
        cmocka_unit_test(a_point_that_is_off_is_found_in_every_column),
        cmocka_unit_test(every_set_measures_alike),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
