/* The geometry fit: known geometries come back from their points, others become tables. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include "core/base/rng.h"
#include "core/base/trig.h"
#include "core/grid/fit.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const struct dx_fit_options automatic = {0, -1};

/* A scanner to be recovered. */
struct scanner {
    uint32_t height, width;
    double azimuth0, azimuth_step, elevation0, elevation_step; /* degrees */
    double stagger;                                            /* azimuth of odd rows, in steps */
    double bend;                         /* unevenness of the elevations, in steps */
    double fx, fy;                       /* pinhole, in pixels */
    double twist;                        /* makes the rows curve: not separable; in steps */
    double holes;                        /* share without a return */
    uint32_t dead_row, dead_col, n_dead; /* runs of lines without any return */
    bool single;                         /* points rounded to f32 */
};

static void spinning_direction(const struct scanner *s, uint32_t row, uint32_t col, double d[3])
{
    double a = s->azimuth0 + s->azimuth_step * (col + (row & 1) * s->stagger);
    double u = (col - s->width / 2.0) / s->width;
    double e =
        s->elevation0 + s->elevation_step * (row + s->bend * dx_sin(0.7 * row) + s->twist * u * u);
    double sa, ca, se, ce;

    dx_sincos(dx_rad(a), &sa, &ca);
    dx_sincos(dx_rad(e), &se, &ce);
    d[0] = ce * ca;
    d[1] = ce * sa;
    d[2] = se;
}

static void pinhole_direction(const struct scanner *s, uint32_t row, uint32_t col, double d[3])
{
    double x = (col - s->width / 2.0 + 0.3) / s->fx, y = (row - s->height / 2.0 - 0.7) / s->fy;
    double r = sqrt(x * x + y * y + 1);

    d[0] = x / r;
    d[1] = y / r;
    d[2] = 1 / r;
}

static void direction(const struct scanner *s, uint32_t row, uint32_t col, double d[3])
{
    if (s->fx != 0)
        pinhole_direction(s, row, col, d);
    else
        spinning_direction(s, row, col, d);
}

static bool is_dead(const struct scanner *s, uint32_t row, uint32_t col)
{
    return (s->n_dead && row >= s->dead_row && row < s->dead_row + s->n_dead) ||
           (s->n_dead && col >= s->dead_col && col < s->dead_col + s->n_dead);
}

/* Random ranges of 1 to 9 m. */
static double *make_points(const struct scanner *s)
{
    double *xyz = malloc((size_t)s->height * s->width * 3 * sizeof(*xyz));
    struct dx_rng g = dx_rng_init(11, s->height * 65536ull + s->width);

    assert_non_null(xyz);
    for (uint32_t row = 0; row < s->height; row++)
        for (uint32_t col = 0; col < s->width; col++) {
            double *p = xyz + 3 * ((size_t)row * s->width + col), d[3];
            double r = 1 + 8 * dx_rng_unit(&g);
            bool hole = dx_rng_unit(&g) < s->holes || is_dead(s, row, col);

            direction(s, row, col, d);
            for (int k = 0; k < 3; k++) {
                p[k] = hole ? NAN : r * d[k];
                if (s->single)
                    p[k] = (double)(float)p[k];
            }
        }
    return xyz;
}

static struct dx_points points_of(const struct scanner *s, const double *xyz)
{
    return (struct dx_points){s->height, s->width, xyz, NULL, 0};
}

/* Largest angle between the geometry and the scanner, in mean steps. */
static double worst_angle(const struct dx_geometry *g, const struct scanner *s)
{
    double step = dx_rad(fabs(s->fx != 0 ? dx_deg(1 / fabs(s->fx)) : s->azimuth_step)), worst = 0;

    for (uint32_t row = 0; row < s->height; row++)
        for (uint32_t col = 0; col < s->width; col++) {
            double want[3], got[3], chord2 = 0;

            direction(s, row, col, want);
            dx_geometry_direction(g, row, col, got);
            for (int k = 0; k < 3; k++)
                chord2 += (want[k] - got[k]) * (want[k] - got[k]);
            worst = sqrt(chord2) > worst ? sqrt(chord2) : worst;
        }
    return worst / step;
}

static struct dx_geometry *fit(const struct scanner *s, struct dx_fit_report *report)
{
    double *xyz = make_points(s);
    struct dx_points points = points_of(s, xyz);
    struct dx_geometry *g = NULL;
    struct dx_err err = {""};

    if (dx_fit_geometry(&g, report, &points, &automatic, &err))
        fail_msg("%s", err.text);
    free(xyz);
    return g;
}

/* Fits, and asserts model, seam and that each direction is within `tolerance` dexels. */
static void assert_fit(const struct scanner *s, enum dx_model model, bool wrap, double tolerance)
{
    struct dx_fit_report report;
    struct dx_geometry *g = fit(s, &report);
    double worst = worst_angle(g, s);

    assert_string_equal(dx_model_name(g->model), dx_model_name(model));
    assert_int_equal(g->wrap, wrap);
    if (!(worst <= tolerance))
        fail_msg("off by %g dexels, expected %g", worst, tolerance);
    if (model != DX_MODEL_TABLE)
        assert_true(report.rms_dexel < 1e-3);
    dx_geometry_unref(g);
}

static const struct scanner turning = {.height = 40,
                                       .width = 180,
                                       .azimuth0 = 17,
                                       .azimuth_step = 2,
                                       .elevation0 = -30,
                                       .elevation_step = 1.5};
static const struct scanner camera = {.height = 48, .width = 64, .fx = 60, .fy = 55};

static void recovers_a_spinning_scanner(void **state)
{
    struct dx_fit_report report;
    struct dx_geometry *g = fit(&turning, &report);

    (void)state;
    assert_int_equal(g->model, DX_MODEL_SPINNING);
    assert_true(g->wrap);
    assert_true(report.rms_dexel < 1e-9 && report.regularity < 1e-9 && report.valid == 1);
    assert_true(fabs(report.azimuth_step_deg - 2) < 1e-9);
    assert_true(fabs(report.elevation_step_deg - 1.5) < 1e-9);
    assert_true(report.max_range_m > 8.9 && report.max_range_m < 9);
    assert_true(fabs((double)g->unit_m - 0.0002) < 1e-9);
    assert_int_equal(g->range_bytes, 2);
    assert_true(worst_angle(g, &turning) < 1e-5);
    dx_geometry_unref(g);
}

static void recovers_either_sense(void **state)
{
    struct dx_fit_report report;
    bool flips[4];

    (void)state;
    for (int k = 0; k < 4; k++) {
        struct scanner s = turning;
        struct dx_geometry *g;

        s.azimuth_step *= k & 1 ? -1 : 1;
        s.elevation_step *= k & 2 ? -1 : 1;
        g = fit(&s, &report);
        assert_int_equal(g->model, DX_MODEL_SPINNING);
        assert_true(g->wrap && worst_angle(g, &s) < 1e-5);
        flips[k] = g->flip;
        dx_geometry_unref(g);
    }
    assert_true(flips[0] != flips[1] && flips[0] != flips[2] && flips[0] == flips[3]);
}

static void recovers_with_holes_and_dead_lines(void **state)
{
    struct scanner s = turning;

    (void)state;
    s.holes = 0.6;
    s.single = true;
    assert_fit(&s, DX_MODEL_SPINNING, true, 1e-4);
    s.n_dead = 3;
    s.dead_row = 20;
    s.dead_col = 80; /* near the jump from pi to -pi */
    assert_fit(&s, DX_MODEL_SPINNING, true, 1e-4);
    s.dead_row = s.dead_col = 0;
    assert_fit(&s, DX_MODEL_SPINNING, true, 1e-4);
    s.dead_row = s.height - 3;
    s.dead_col = s.width - 3;
    assert_fit(&s, DX_MODEL_SPINNING, true, 1e-4);
}

static void recovers_uneven_rows_and_stagger(void **state)
{
    struct scanner s = turning;

    (void)state;
    s.bend = 0.3;
    assert_fit(&s, DX_MODEL_SPINNING, true, 1e-5);
    s.stagger = 0.5;
    s.holes = 0.4;
    assert_fit(&s, DX_MODEL_SPINNING, true, 1e-5);
    s.stagger = -4.25;
    assert_fit(&s, DX_MODEL_SPINNING, true, 1e-5);
}

static void recovers_up_to_the_poles(void **state)
{
    struct scanner s = turning;

    (void)state;
    s.height = 180;
    s.elevation0 = -89.5;
    s.elevation_step = 1;
    s.single = true;
    assert_fit(&s, DX_MODEL_SPINNING, true, 1e-3);
    s.elevation0 = -90; /* a row at the pole itself */
    s.height = 181;
    assert_fit(&s, DX_MODEL_SPINNING, true, 1e-3);
}

static void closes_the_seam_only_when_it_closes(void **state)
{
    struct scanner s = turning;

    (void)state;
    s.width = 179; /* a column is missing */
    assert_fit(&s, DX_MODEL_SPINNING, false, 1e-5);
    s.width = 181; /* one twice */
    assert_fit(&s, DX_MODEL_SPINNING, false, 1e-5);
    s.width = 90;
    assert_fit(&s, DX_MODEL_SPINNING, false, 1e-5);
    s.width = 6; /* too narrow to close */
    s.azimuth_step = 60;
    assert_fit(&s, DX_MODEL_SPINNING, false, 1e-5);
}

static void recovers_cameras(void **state)
{
    struct scanner s = camera;

    (void)state;
    assert_fit(&s, DX_MODEL_PINHOLE, false, 1e-4);
    s.fx = -60; /* mirrored */
    assert_fit(&s, DX_MODEL_PINHOLE, false, 1e-4);
    s.fy = -55;
    s.single = true;
    s.holes = 0.5;
    s.n_dead = 5; /* the border that a depth camera lacks */
    assert_fit(&s, DX_MODEL_PINHOLE, false, 1e-3);
}

static void reports_a_camera(void **state)
{
    struct dx_fit_report report;
    struct dx_geometry *g = fit(&camera, &report);

    (void)state;
    assert_true(report.rms_dexel < 1e-9 && report.rms_dexel == report.rms_pinhole);
    assert_true(report.rms_spinning > 1);
    assert_true(fabs(report.azimuth_step_deg - dx_deg(dx_atan2(1, 60))) < 1e-9);
    dx_geometry_unref(g);
}

/* Rows that curve by up to 1.5 steps: a table, exact at the returns and close where there is none.
 */
static void makes_a_table_of_the_rest(void **state)
{
    struct scanner s = turning;
    struct dx_fit_report report;
    struct dx_geometry *g;

    (void)state;
    s.twist = 6;
    g = fit(&s, &report);
    assert_int_equal(g->model, DX_MODEL_TABLE);
    assert_true(worst_angle(g, &s) < 1e-5);
    assert_true(report.rms_dexel == 0 && report.rms_spinning > 0.1);
    assert_int_equal(g->flip, true);
    dx_geometry_unref(g);
    s.holes = 0.5;
    assert_fit(&s, DX_MODEL_TABLE, true, 0.25);
}

static void keeps_to_the_options(void **state)
{
    struct dx_fit_options options = {0.0001, 0};
    struct dx_fit_report report;
    double *xyz = make_points(&turning);
    struct dx_points points = points_of(&turning, xyz);
    struct dx_geometry *g;
    struct dx_err err;

    (void)state;
    assert_int_equal(dx_fit_geometry(&g, &report, &points, &options, &err), 0);
    assert_false(g->wrap);
    assert_int_equal(g->range_bytes, 4); /* 9 m of 0.1 mm */
    assert_true(g->unit_m == 0.0001f);
    dx_geometry_unref(g);
    points.width = 90; /* reads the rows askew: a table, but the seam was asked for */
    points.height = 80;
    options = (struct dx_fit_options){0.001, 1};
    assert_int_equal(dx_fit_geometry(&g, &report, &points, &options, &err), 0);
    assert_true(g->wrap);
    assert_int_equal(g->range_bytes, 2);
    dx_geometry_unref(g);
    free(xyz);
}

static void assert_refused(const struct dx_points *points, const struct dx_fit_options *options,
                           int code, const char *message)
{
    struct dx_fit_report report;
    struct dx_geometry *g;
    struct dx_err err = {""};

    assert_int_equal(dx_fit_geometry(&g, &report, points, options, &err), code);
    if (!strstr(err.text, message))
        fail_msg("\"%s\", expected \"%s\"", err.text, message);
}

static void refuses_what_cannot_be_fitted(void **state)
{
    struct scanner s = turning;
    double *xyz = make_points(&s);
    struct dx_points points = points_of(&s, xyz);

    (void)state;
    for (size_t k = 15; k < (size_t)s.height * s.width; k++)
        xyz[3 * k + k % 3] = k % 2 ? NAN : INFINITY;
    assert_refused(&points, &automatic, -ENODATA, "15 of 180x40 points are returns");
    points.width = 0;
    assert_refused(&points, &automatic, -EINVAL, "0x40");
    points.width = 65536;
    assert_refused(&points, &automatic, -EINVAL, "65536x40");
    points.width = points.height = 40000;
    assert_refused(&points, &automatic, -EINVAL, "40000x40000");
    points.width = 7;
    points.height = 40;
    assert_refused(&points, &(struct dx_fit_options){0, 1}, -EINVAL, "seam closed on 7 columns");
    assert_refused(&points, &(struct dx_fit_options){-1, 0}, -EINVAL, "unit of -1");
    assert_refused(&points, &(struct dx_fit_options){NAN, 0}, -EINVAL, "unit of");
    free(xyz);
}

/* Whatever the numbers are, the result is finite. */
static void stands_any_numbers(void **state)
{
    static const double values[] = {0,    -0.0, 1,        -1,        1e-300, 1e300, -1e11, 1e11,
                                    1e-9, NAN,  INFINITY, -INFINITY, 3,      1e-13, 5e5,   -2e-6};
    struct dx_rng g = dx_rng_init(3, 1);
    double xyz[12 * 12 * 3];

    (void)state;
    for (int round = 0; round < 2000; round++) {
        uint32_t width = 1 + dx_rng_below(&g, 12), height = 1 + dx_rng_below(&g, 12);
        struct dx_points points = {height, width, xyz, NULL, 0};
        uint32_t kinds = 1 + dx_rng_below(&g, 16);
        struct dx_fit_report report;
        struct dx_geometry *geometry = NULL;
        struct dx_plane plane;

        for (size_t k = 0; k < 3 * (size_t)width * height; k++)
            xyz[k] = dx_rng_below(&g, 4) ? values[dx_rng_below(&g, kinds)] : dx_rng_unit(&g);
        if (dx_fit_geometry(&geometry, &report, &points, &automatic, NULL))
            continue;
        for (size_t k = 0; k < geometry->n_table; k++)
            assert_true(isfinite(geometry->table[k]));
        assert_true(geometry->unit_m > 0 && isfinite(geometry->unit_m));
        assert_true(isfinite(report.max_range_m) && isfinite(report.regularity));
        assert_int_equal(dx_plane_init(&plane, height, width, geometry->range_bytes, 0), 0);
        dx_fit_ranges(&plane, geometry, &points);
        dx_plane_fini(&plane);
        dx_geometry_unref(geometry);
    }
}

/* Every dexel's point is where it was, to half a unit and the f32 rounding. */
static void ranges_give_the_points_back(void **state)
{
    const struct scanner *const scanners[] = {&turning, &camera};

    (void)state;
    for (int n = 0; n < 2; n++) {
        const struct scanner *s = scanners[n];
        struct dx_fit_report report;
        struct dx_geometry *g = fit(s, &report);
        double *xyz = make_points(s);
        struct dx_points points = points_of(s, xyz);
        struct dx_plane plane;

        assert_int_equal(dx_plane_init(&plane, s->height, s->width, 2, 0), 0);
        assert_int_equal(dx_fit_ranges(&plane, g, &points), 0);
        for (size_t k = 0; k < dx_plane_n_dexels(&plane); k++) {
            double d2 = 0;
            float p[3];

            dx_geometry_point(g, (uint32_t)(k / s->width), (uint32_t)(k % s->width),
                              dx_plane_range(&plane, k), p);
            for (int i = 0; i < 3; i++)
                d2 += (p[i] - xyz[3 * k + (size_t)i]) * (p[i] - xyz[3 * k + (size_t)i]);
            assert_true(sqrt(d2) < (double)g->unit_m + 1e-5);
        }
        dx_plane_fini(&plane);
        free(xyz);
        dx_geometry_unref(g);
    }
}

static void drops_ranges_that_do_not_fit(void **state)
{
    uint16_t attr[8] = {1, 2, 3, 4, 5, 6, 7, 255};
    double xyz[8 * 3] = {NAN,    NAN, NAN, INFINITY, 0, 0, 65.535, 0, 0, 65.536, 0, 0,
                         0.0004, 0,   0,   0.0006,   0, 0, 1e300,  0, 0, 3,      0, 4};
    const uint32_t want[8] = {0, 0, 65535, 0, 0, 1, 0, 5000},
                   want_attr[8] = {0, 0, 3, 0, 0, 6, 0, 255};
    struct dx_points points = {1, 8, xyz, attr, 1};
    struct dx_geometry *g;
    struct dx_plane plane;

    (void)state;
    assert_int_equal(dx_geometry_new_spinning(&g, 1, 8, 0, 0.1, 0, 0), 0);
    assert_int_equal(dx_plane_init(&plane, 1, 8, 2, 1), 0);
    assert_int_equal(dx_fit_ranges(&plane, g, &points), 4);
    for (size_t k = 0; k < 8; k++) {
        assert_int_equal(dx_plane_range(&plane, k), want[k]);
        assert_int_equal(dx_plane_attr(&plane, k), want_attr[k]);
    }
    dx_plane_fini(&plane);
    dx_geometry_unref(g);
}

/* A frame whose scanner has turned by part of a step still lies in the geometry, or no longer. */
static void tells_departures(void **state)
{
    struct dx_fit_report report;
    struct dx_geometry *first = fit(&turning, &report);
    const double shifts[] = {0, 0.3, 0.45, 0.55, 2};

    (void)state;
    for (int k = 0; k < 5; k++) {
        struct scanner s = turning;
        struct dx_geometry *g;
        double *xyz;
        struct dx_points points;

        s.azimuth0 += shifts[k] * s.azimuth_step;
        g = fit(&s, &report);
        xyz = make_points(&s);
        points = points_of(&s, xyz);
        assert_int_equal(dx_geometry_departure(first, g) <= 0.5, shifts[k] < 0.5);
        assert_int_equal(dx_fit_holds(first, &points, 0.5), shifts[k] < 0.5);
        xyz[0] *= 5; /* direction and range of one point */
        assert_false(dx_fit_holds(first, &points, 0.5));
        points.width--;
        assert_false(dx_fit_holds(first, &points, 0.5));
        free(xyz);
        dx_geometry_unref(g);
    }
    dx_geometry_unref(first);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(recovers_a_spinning_scanner),
        cmocka_unit_test(recovers_either_sense),
        cmocka_unit_test(recovers_with_holes_and_dead_lines),
        cmocka_unit_test(recovers_uneven_rows_and_stagger),
        cmocka_unit_test(recovers_up_to_the_poles),
        cmocka_unit_test(closes_the_seam_only_when_it_closes),
        cmocka_unit_test(recovers_cameras),
        cmocka_unit_test(reports_a_camera),
        cmocka_unit_test(makes_a_table_of_the_rest),
        cmocka_unit_test(keeps_to_the_options),
        cmocka_unit_test(refuses_what_cannot_be_fitted),
        cmocka_unit_test(stands_any_numbers),
        cmocka_unit_test(ranges_give_the_points_back),
        cmocka_unit_test(drops_ranges_that_do_not_fit),
        cmocka_unit_test(tells_departures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
