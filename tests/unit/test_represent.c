/*
 * The representative of each dexel against an oracle that shares no code with it: dexels by angles
 * and division, policies by sorting all samples of a dexel.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "core/base/rng.h"
#include "core/base/trig.h"
#include "core/grid/represent.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define N_SAMPLES 6000
#define NONE      UINT32_MAX
/* Samples this close to an edge between dexels (in dexels) are not drawn: angles round. */
#define CLEAR 1e-4

/* An even scanner, radians; pinhole: tangents. */
struct view {
    bool pinhole;
    uint32_t height, width;
    double col0, col_step, row0, row_step;
    bool wrap;
    double squeeze[3]; /* of most samples' directions, to where the view is */
};

static const struct view views[] = {
    {false, 23, 40, 0.1, 2 * DX_PI / 40, -0.7, 0.06, true, {1, 1, 0.5}},
    /* counts the other way */
    {false, 23, 40, 3.0, -2 * DX_PI / 40, 0.7, -0.06, true, {1, 1, 0.5}},
    /* across the azimuth of 180 degrees */
    {false, 17, 31, 2.5, 0.05, -0.4, 0.05, false, {1, 1, 0.3}},
    /* reaches over the pole */
    {false, 9, 12, -3.0, 2 * DX_PI / 12, 1.15, 0.05, true, {0.3, 0.3, 1}},
    {true, 20, 30, -0.6, 0.04, 0.5, -0.05, false, {0.5, 0.5, 1}},
};

#define N_VIEWS (sizeof(views) / sizeof(views[0]))

struct set {
    double xyz[3 * N_SAMPLES];
    uint16_t attr[N_SAMPLES];
    uint32_t dexel[N_SAMPLES]; /* the oracle's, NONE outside */
    uint32_t range[N_SAMPLES];
    double off_axis[N_SAMPLES];
};

static struct dx_geometry *make_geometry(const struct view *v)
{
    struct dx_geometry *g;

    if (v->pinhole)
        assert_int_equal(dx_geometry_new_pinhole(&g, v->height, v->width, 1 / v->col_step,
                                                 1 / v->row_step, -v->col0 / v->col_step,
                                                 -v->row0 / v->row_step),
                         0);
    else
        assert_int_equal(dx_geometry_new_spinning(&g, v->height, v->width, v->col0, v->col_step,
                                                  v->row0, v->row_step),
                         0);
    assert_int_equal(g->wrap, v->wrap);
    return g;
}

/* The line nearest to a value, or NONE; false when the value is too near to an edge. */
static bool line_of(uint32_t *line, double v, double v0, double step, uint32_t n)
{
    double at = (v - v0) / step + 0.5;

    *line = at >= 0 && at < n ? (uint32_t)at : NONE;
    return fabs(at - rint(at)) > CLEAR;
}

static double angle_between(const double a[3], const double b[3])
{
    double c[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};

    return dx_atan2(sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]),
                    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
}

/* Which dexel a sample falls into; false: do not use the sample. */
static bool oracle_place(struct set *s, size_t k, const struct view *v, const struct dx_geometry *g)
{
    const double *p = s->xyz + 3 * k;
    double r = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]), axis[3];
    double u = v->pinhole ? p[0] / p[2] : dx_atan2(p[1], p[0]);
    double w = v->pinhole ? p[1] / p[2] : dx_atan2(p[2], sqrt(p[0] * p[0] + p[1] * p[1]));
    uint32_t row, col;
    bool clear;

    if (v->pinhole && p[2] <= 0) {
        s->dexel[k] = NONE;
        return true;
    }
    if (!v->pinhole) { /* to the turn that begins half a step before column 0 */
        double turns = (u - v->col0) / (2 * DX_PI) * (v->col_step < 0 ? -1 : 1);

        turns += 0.5 * fabs(v->col_step) / (2 * DX_PI);
        u -= floor(turns) * 2 * DX_PI * (v->col_step < 0 ? -1 : 1);
    }
    clear = line_of(&col, u, v->col0, v->col_step, v->width);
    clear = line_of(&row, w, v->row0, v->row_step, v->height) && clear;
    s->dexel[k] = row == NONE || col == NONE ? NONE : row * v->width + col;
    s->range[k] = (uint32_t)rint((v->pinhole ? p[2] : r) / (double)g->unit_m);
    if (s->dexel[k] != NONE) {
        dx_geometry_direction(g, row, col, axis);
        s->off_axis[k] = angle_between(axis, p);
    }
    return clear;
}

/* Samples in all directions, with ranges that often coincide. */
static void draw(struct set *s, const struct view *v, const struct dx_geometry *g)
{
    struct dx_rng rng = dx_rng_init(5, v->width);

    for (size_t k = 0; k < N_SAMPLES;) {
        double d[3], r = (1000 + dx_rng_below(&rng, 9)) * 0.001, len = 0;
        bool there = dx_rng_below(&rng, 3) != 0;

        for (int i = 0; i < 3; i++)
            d[i] = (2 * dx_rng_unit(&rng) - 1) * (there ? v->squeeze[i] : 1);
        for (int i = 0; i < 3; i++)
            len += d[i] * d[i];
        for (size_t i = 0; i < 3; i++)
            s->xyz[3 * k + i] = d[i] * r / sqrt(len);
        s->attr[k] = (uint16_t)dx_rng_below(&rng, 65536);
        k += oracle_place(s, k, v, g);
    }
}

/* What one dexel keeps, from all samples. */
struct want {
    uint32_t range, attr, number;
};

/* Of two samples of one dexel, which comes first under a policy; by number in the end. */
static bool before(const struct set *s, uint32_t a, uint32_t b, enum dx_keep keep)
{
    if (keep == DX_KEEP_CENTRE) {
        uint32_t x = (uint32_t)(s->off_axis[a] * 0x1p30), y = (uint32_t)(s->off_axis[b] * 0x1p30);

        return x != y ? x < y : a < b;
    }
    if (keep == DX_KEEP_FIRST)
        return a < b;
    return s->range[a] != s->range[b] ? s->range[a] < s->range[b] : a < b;
}

static struct want oracle(const struct set *s, uint32_t dexel, enum dx_keep keep)
{
    uint32_t in[N_SAMPLES], n = 0;
    uint64_t range = 0, attr = 0;

    for (uint32_t k = 0; k < N_SAMPLES; k++) {
        uint32_t at = n;

        if (s->dexel[k] != dexel)
            continue;
        for (; at > 0 && before(s, k, in[at - 1], keep); at--)
            in[at] = in[at - 1];
        in[at] = k;
        n++;
        range += s->range[k];
        attr += s->attr[k];
    }
    if (n == 0)
        return (struct want){0, 0, NONE};
    if (keep == DX_KEEP_MEAN)
        return (struct want){(uint32_t)((2 * range + n) / (2 * n)),
                             (uint32_t)((2 * attr + n) / (2 * n)), NONE};
    n = in[keep == DX_KEEP_MEDIAN ? (n - 1) / 2 : 0];
    return (struct want){s->range[n], s->attr[n], n};
}

static void every_policy_is_the_oracles(void **state)
{
    static struct set s;

    (void)state;
    for (size_t v = 0; v < N_VIEWS; v++) {
        struct dx_geometry *g = make_geometry(&views[v]);
        uint32_t n_dexels = g->height * g->width, *kept = calloc(n_dexels, sizeof(*kept));
        struct dx_plane plane;

        draw(&s, &views[v], g);
        assert_int_equal(dx_plane_init(&plane, g->height, g->width, 2, 2), 0);
        for (unsigned keep = 0; keep < DX_N_KEEP; keep++) {
            const struct dx_samples all = {.n = N_SAMPLES, .xyz = s.xyz, .attr = s.attr};
            const struct dx_represent_counts *counts;
            struct dx_represent *r;
            uint64_t outside = 0;

            assert_int_equal(dx_represent_new(&r, g, (enum dx_keep)keep, N_SAMPLES), 0);
            for (int frame = 0; frame < 2; frame++) { /* the second after a reset */
                assert_int_equal(dx_represent_add(r, &all), 0);
                dx_represent_finish(r, &plane, kept);
                if (frame == 0)
                    dx_represent_reset(r);
            }
            for (uint32_t k = 0; k < n_dexels; k++) {
                struct want want = oracle(&s, k, (enum dx_keep)keep);

                assert_int_equal(dx_plane_range(&plane, k), want.range);
                assert_int_equal(dx_plane_attr(&plane, k), want.attr);
                assert_int_equal(kept[k], want.number);
            }
            for (uint32_t k = 0; k < N_SAMPLES; k++)
                outside += s.dexel[k] == NONE;
            counts = dx_represent_counts(r);
            assert_true(outside > 100 && outside < N_SAMPLES - 200);
            assert_int_equal(counts->outside, outside);
            assert_int_equal(counts->taken, N_SAMPLES - outside);
            assert_int_equal(counts->missing + counts->unfit, 0);
            dx_represent_free(r);
        }
        dx_plane_fini(&plane);
        free(kept);
        dx_geometry_unref(g);
    }
}

/* One at a time in another order, each with the number that it has. */
static void order_does_not_matter(void **state)
{
    static struct set s;
    static uint32_t order[N_SAMPLES];
    struct dx_geometry *g = make_geometry(&views[0]);
    struct dx_rng rng = dx_rng_init(6, 0);
    struct dx_plane plane[2];

    (void)state;
    draw(&s, &views[0], g);
    for (uint32_t k = 0; k < N_SAMPLES; k++) {
        uint32_t other = dx_rng_below(&rng, k + 1);

        order[k] = order[other];
        order[other] = k;
    }
    for (unsigned keep = 0; keep < DX_N_KEEP; keep++) {
        const struct dx_samples all = {.n = N_SAMPLES, .xyz = s.xyz, .attr = s.attr};
        struct dx_represent *r;

        assert_int_equal(dx_represent_new(&r, g, (enum dx_keep)keep, N_SAMPLES), 0);
        assert_int_equal(dx_plane_init(&plane[0], g->height, g->width, 2, 2), 0);
        assert_int_equal(dx_plane_init(&plane[1], g->height, g->width, 2, 2), 0);
        assert_int_equal(dx_represent_add(r, &all), 0);
        dx_represent_finish(r, &plane[0], NULL);
        dx_represent_reset(r);
        for (uint32_t k = 0; k < N_SAMPLES; k++) {
            const struct dx_samples one = {1, s.xyz + 3 * order[k], NULL, s.attr + order[k],
                                           order[k]};

            assert_int_equal(dx_represent_add(r, &one), 0);
        }
        dx_represent_finish(r, &plane[1], NULL);
        assert_memory_equal(plane[0].range, plane[1].range, 2 * dx_plane_n_dexels(&plane[0]));
        assert_memory_equal(plane[0].attr, plane[1].attr, 2 * dx_plane_n_dexels(&plane[0]));
        dx_plane_fini(&plane[0]);
        dx_plane_fini(&plane[1]);
        dx_represent_free(r);
    }
    dx_geometry_unref(g);
}

/* f32 points, 32-bit ranges, no attribute. */
static void singles_and_wide_ranges(void **state)
{
    const float xyz[] = {70, 0, 0, 0, 90, 0, 0, 100, 0};
    const struct dx_samples samples = {.n = 3, .xyz32 = xyz};
    struct dx_geometry *g;
    struct dx_represent *r;
    struct dx_plane plane;

    (void)state;
    assert_int_equal(dx_geometry_new_spinning(&g, 3, 8, 0, DX_PI / 4, -0.1, 0.1), 0);
    g->range_bytes = 4;
    assert_int_equal(dx_plane_init(&plane, 3, 8, 4, 0), 0);
    assert_int_equal(dx_represent_new(&r, g, DX_KEEP_NEAREST, 3), 0);
    assert_int_equal(dx_represent_add(r, &samples), 0);
    dx_represent_finish(r, &plane, NULL);
    for (size_t k = 0; k < 24; k++)
        assert_int_equal(dx_plane_range(&plane, k), k == 8 ? 70000 : k == 10 ? 90000 : 0);
    dx_represent_free(r);
    dx_plane_fini(&plane);
    dx_geometry_unref(g);
}

/* On both sides of the seam, and on the seam's own edge, which belongs to one dexel or the other
 * but never to none. */
static void the_seam_has_no_gap(void **state)
{
    struct dx_geometry *g;
    struct dx_represent *r;

    (void)state;
    assert_int_equal(dx_geometry_new_spinning(&g, 2, 360, 0.3, 2 * DX_PI / 360, -0.5, 1.0), 0);
    assert_true(g->wrap);
    assert_int_equal(dx_represent_new(&r, g, DX_KEEP_FIRST, UINT32_MAX), 0);
    for (int k = -40; k <= 40; k++) {
        double a = 0.3 - DX_PI / 360 + k * 1e-17, p[3] = {dx_cos(a), dx_sin(a), 0.01};
        const struct dx_samples one = {.n = 1, .xyz = p, .number = (uint32_t)(k + 40)};

        p[1] += k * 1e-17;
        assert_int_equal(dx_represent_add(r, &one), 0);
    }
    assert_int_equal(dx_represent_counts(r)->taken, 81);
    dx_represent_free(r);
    dx_geometry_unref(g);
}

static void what_is_no_return_is_counted(void **state)
{
    const double xyz[] = {NAN, 1,        1, 1,      INFINITY, 1, 0,     0, 0, 1e300, 1e300, 1,
                          66,  0.000001, 0, 0.0001, 0,        0, 0.001, 0, 5, 2,     0,     0};
    const struct dx_samples samples = {.n = 8, .xyz = xyz};
    const struct dx_represent_counts *counts;
    struct dx_geometry *g;
    struct dx_represent *r;
    struct dx_plane plane;
    uint32_t kept[16];

    (void)state;
    assert_int_equal(dx_geometry_new_spinning(&g, 2, 8, 0, DX_PI / 4, -0.1, 0.1), 0);
    assert_int_equal(dx_plane_init(&plane, 2, 8, 2, 0), 0);
    for (unsigned keep = 0; keep < DX_N_KEEP; keep++) {
        assert_int_equal(dx_represent_new(&r, g, (enum dx_keep)keep, 8), 0);
        assert_int_equal(dx_represent_add(r, &samples), 0);
        counts = dx_represent_counts(r);
        assert_int_equal(counts->missing, 4);
        assert_int_equal(counts->unfit, 2); /* 66 m and 0.1 mm in steps of 1 mm */
        assert_int_equal(counts->outside, 1);
        assert_int_equal(counts->taken, 1);
        dx_represent_finish(r, &plane, kept);
        for (size_t k = 0; k < 16; k++) {
            assert_int_equal(dx_plane_range(&plane, k), k == 8 ? 2000 : 0);
            assert_int_equal(kept[k], k == 8 && keep != DX_KEEP_MEAN ? 7 : NONE);
        }
        dx_represent_free(r);
    }
    dx_plane_fini(&plane);
    dx_geometry_unref(g);
}

static void more_samples_than_announced_are_refused(void **state)
{
    const double xyz[] = {1, 0, 0, 1, 0, 0, 1, 0, 0};
    struct dx_geometry *g;
    struct dx_represent *r;

    (void)state;
    assert_int_equal(dx_geometry_new_spinning(&g, 2, 8, 0, DX_PI / 4, -0.1, 0.1), 0);
    for (unsigned keep = 0; keep < DX_N_KEEP; keep++) {
        assert_int_equal(dx_represent_new(&r, g, (enum dx_keep)keep, 4), 0);
        assert_int_equal(dx_represent_add(r, &(struct dx_samples){.n = 3, .xyz = xyz}), 0);
        assert_int_equal(dx_represent_add(r, &(struct dx_samples){.n = 2, .xyz = xyz, .number = 3}),
                         -ERANGE);
        assert_int_equal(dx_represent_add(r, &(struct dx_samples){.n = 3, .xyz = xyz}), -ERANGE);
        assert_int_equal(dx_represent_add(r, &(struct dx_samples){.n = 1, .xyz = xyz, .number = 9}),
                         -ERANGE);
        assert_int_equal(dx_represent_counts(r)->taken, 3);
        dx_represent_free(r);
    }
    dx_geometry_unref(g);
}

static void geometries_it_cannot_serve_are_refused(void **state)
{
    struct dx_geometry *g;
    struct dx_represent *r;

    (void)state;
    assert_int_equal(dx_geometry_new(&g, DX_MODEL_TABLE, 4, 8), 0);
    assert_int_equal(dx_represent_new(&r, g, DX_KEEP_CENTRE, 10), -EINVAL);
    dx_geometry_unref(g);
    assert_int_equal(dx_geometry_new_spinning(&g, 4, 8, 0, 0.1, 0, 0.1), 0);
    assert_int_equal(dx_represent_new(&r, g, DX_N_KEEP, 10), -EINVAL);
    g->table[2 * 8 + 1] = 0.01f; /* an azimuth offset of row 0 */
    assert_int_equal(dx_represent_new(&r, g, DX_KEEP_CENTRE, 10), -EINVAL);
    g->table[2 * 8 + 1] = 0;
    g->table[2 * 3] = -1; /* column 3 looks back */
    assert_int_equal(dx_represent_new(&r, g, DX_KEEP_CENTRE, 10), -EINVAL);
    dx_geometry_unref(g);
}

static void names_are_a_list(void **state)
{
    (void)state;
    assert_string_equal(dx_keep_name(DX_KEEP_CENTRE), "centre");
    for (unsigned k = 0; k < DX_N_KEEP; k++)
        assert_non_null(dx_keep_name(k));
    assert_null(dx_keep_name(DX_N_KEEP));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_policy_is_the_oracles),
        cmocka_unit_test(order_does_not_matter),
        cmocka_unit_test(singles_and_wide_ranges),
        cmocka_unit_test(the_seam_has_no_gap),
        cmocka_unit_test(what_is_no_return_is_counted),
        cmocka_unit_test(more_samples_than_announced_are_refused),
        cmocka_unit_test(geometries_it_cannot_serve_are_refused),
        cmocka_unit_test(names_are_a_list),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
