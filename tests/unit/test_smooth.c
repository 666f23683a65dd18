/*
 * Smoothing along the beam (docs/terrain.md): what it is, by an oracle that shares no code with it,
 * and what it does: noise goes, planes stay, nothing crosses a cut, no sample leaves its dexel.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "core/grid/sigma.h"
#include "smooth_oracle.h"
#include "terrain_rig.h"

static struct dx_terrain *smoothed(struct dx_geometry *g, const struct dx_terrain_params *params,
                                   const struct dx_plane *p)
{
    struct dx_terrain_params q = *params;

    q.smooth = true;
    return meshed(g, &q, p, NULL);
}

/* ---- the definition ------------------------------------------------------------------------- */

/* How many ranges are not those of the frame. */
static size_t assert_as_defined(const struct dx_terrain *t, const struct dx_plane *p, int k)
{
    const struct dx_plane *got = dx_terrain_published(t);
    const uint32_t width = p->width;
    size_t n_moved = 0;
    struct oracle o;

    oracle_init(&o, dx_terrain_geometry(t), p, dx_terrain_params(t));
    for (uint32_t i = 0; i < p->height; i++)
        for (uint32_t j = 0; j < width; j++) {
            const uint32_t want = oracle_smoothed(&o, i, j, 1);
            const uint32_t range = dx_plane_range(got, (size_t)i * width + j);

            if (range != want)
                fail_msg("frame %d, model %d, %u x %u, dexel (%u, %u): %u, expected %u", k,
                         (int)o.g->model, p->height, width, i, j, range, want);
            n_moved += range != o.range[(size_t)i * width + j];
        }
    oracle_fini(&o);
    return n_moved;
}

static void the_kernel_equals_the_definition(void **state)
{
    const int n = long_run() ? 20000 : 60;
    struct dx_rng rng = dx_rng_init(23, 0);
    size_t n_moved = 0;

    (void)state;
    for (int k = 0; k < n; k++) {
        const uint32_t side = k % 5 ? 12 : 150, height = 2 + dx_rng_below(&rng, side);
        struct dx_geometry *g =
            any_geometry(&rng, height, 2 + dx_rng_below(&rng, side), k & 1 ? 2 : 4);
        struct dx_terrain_params q;
        struct dx_terrain *t;
        struct dx_plane p;

        assert_int_equal(dx_plane_init(&p, g->height, g->width, g->range_bytes, 0), 0);
        any_frame(&p, &rng);
        any_rules(&q, &variants[dx_rng_below(&rng, (uint32_t)N_VARIANTS)], &rng);
        t = smoothed(g, &q, &p);
        n_moved += assert_as_defined(t, &p, k);
        dx_terrain_free(t);
        dx_plane_fini(&p);
        dx_geometry_unref(g);
    }
    assert_true(n_moved > 100 * (size_t)n);
}

/* Scenes with all that rules are for; the mesh is that of the smoothed array. */
static void the_mesh_is_that_of_the_smoothed_array(void **state)
{
    static const enum dx_scene scenes[] = {DX_SCENE_HALL, DX_SCENE_OPEN, DX_SCENE_MOVING_BOX};

    (void)state;
    for (int k = 0; k < 3; k++) {
        struct dx_terrain_params q;
        struct dx_scene_config c;
        struct dx_geometry *g;
        struct dx_terrain *t;
        struct dx_plane p;

        rough_scene(&c, scenes[k], 100, 150);
        g = scene_frame(&c, &p);
        dx_terrain_params_default(&q);
        q.sigma_given = true;
        q.sigma[0] = 0.005;
        t = smoothed(g, &q, &p);
        assert_true(assert_as_defined(t, &p, k) > 5000);
        assert_true(assert_right(t) > 10000);
        dx_terrain_free(t);
        dx_plane_fini(&p);
        dx_geometry_unref(g);
    }
}

/* ---- planes --------------------------------------------------------------------------------- */

#define UNIT_M 0.001
#define NOISE  10 /* units */

enum grid { GRID_TURN, GRID_UNEVEN_TURN, GRID_PINHOLE, GRID_TABLE, N_GRIDS };

static struct dx_geometry *grid_of(enum grid kind, uint32_t height, uint32_t width,
                                   struct dx_rng *rng)
{
    struct dx_geometry *g;

    if (kind <= GRID_UNEVEN_TURN)
        assert_int_equal(dx_geometry_new_spinning(&g, height, width, -0.5, 0.01, -0.4, 0.01), 0);
    else if (kind == GRID_PINHOLE)
        assert_int_equal(dx_geometry_new_pinhole(&g, height, width, 100, 100, width / 2.0, 40), 0);
    else
        assert_int_equal(dx_geometry_new(&g, DX_MODEL_TABLE, height, width), 0);
    if (kind == GRID_UNEVEN_TURN)
        turn_unevenly(g, 0.01, 0.3);
    if (kind == GRID_TABLE)
        scatter_table(g, 0.01, 0.01, 0.6, rng);
    g->range_bytes = 2;
    g->unit_m = (float)UNIT_M;
    return g;
}

/* The plane a x + b y + c z = 1 with normal noise. */
static void see_plane(struct dx_plane *p, const struct dx_geometry *g, const double n[3],
                      double noise, struct dx_rng *rng)
{
    for (uint32_t i = 0; i < g->height; i++)
        for (uint32_t j = 0; j < g->width; j++) {
            const size_t k = (size_t)i * g->width + j;
            double d[3], r;

            linear_direction(g, (int64_t)k, d);
            r = 1 / (dot(d, n) * UNIT_M);
            assert_true(r > 100 && r < 60000);
            dx_plane_set_range(p, k, (uint32_t)rint(r + noise * dx_rng_normal(rng)));
        }
}

/* Root mean square of a plane's departures from another's ranges, units; edges left out. */
static double rms_apart(const struct dx_plane *a, const struct dx_plane *b, uint32_t margin)
{
    double sum = 0;
    size_t n = 0;

    for (uint32_t i = margin; i < a->height - margin; i++)
        for (uint32_t j = margin; j < a->width - margin; j++) {
            const size_t k = (size_t)i * a->width + j;
            const double e = (double)dx_plane_range(a, k) - dx_plane_range(b, k);

            sum += e * e;
            n++;
        }
    return sqrt(sum / (double)n);
}

/* Where the beam is steep, too: planes seen at up to 80 degrees. */
static void planes_stay_and_noise_goes(void **state)
{
    static const double walls[3][3] = {{0.2, 0, 0}, {0.12, 0.06, 0.08}, {0.09, 0.03, 0.06}};
    struct dx_rng rng = dx_rng_init(5, 0);

    (void)state;
    for (enum grid kind = 0; kind < N_GRIDS; kind++)
        for (int w = 0; w < 3; w++) {
            struct dx_geometry *g = grid_of(kind, 80, 100, &rng);
            const double *n = walls[w], ahead[3] = {n[1], n[2], n[0]}; /* they look along z */
            struct dx_plane truth, noisy;
            struct dx_terrain_params q;
            struct dx_terrain *t;

            dx_terrain_params_default(&q);
            q.sigma_given = true;
            q.sigma[0] = NOISE * UNIT_M;
            assert_int_equal(dx_plane_init_for(&truth, g, 0), 0);
            assert_int_equal(dx_plane_init_for(&noisy, g, 0), 0);
            see_plane(&truth, g, kind >= GRID_PINHOLE ? ahead : n, 0, &rng);
            see_plane(&noisy, g, kind >= GRID_PINHOLE ? ahead : n, NOISE, &rng);
            t = smoothed(g, &q, &truth);
            assert_true(rms_apart(dx_terrain_published(t), &truth, 0) < 0.5);
            dx_terrain_free(t);
            t = smoothed(g, &q, &noisy);
            assert_true(rms_apart(&noisy, &truth, 0) > 0.95 * NOISE);
            assert_true(rms_apart(dx_terrain_published(t), &truth, 2) < 0.33 * NOISE);
            assert_true(rms_apart(dx_terrain_published(t), &truth, 0) < 0.4 * NOISE);
            dx_terrain_free(t);
            dx_plane_fini(&noisy);
            dx_plane_fini(&truth);
            dx_geometry_unref(g);
        }
}

/* ---- what does not happen ------------------------------------------------------------------- */

/* Samples stay in their dexels: none is made, none lost, none moved by more than three sigmas. */
static void no_sample_goes_far(void **state)
{
    struct dx_rng rng = dx_rng_init(6, 0);

    (void)state;
    for (int k = 0; k < 24; k++) {
        struct dx_geometry *g = any_geometry(&rng, 20, 30, k & 1 ? 2 : 4);
        struct dx_terrain_params q;
        struct dx_terrain *t;
        struct dx_sigma sigma;
        struct dx_plane p;

        assert_int_equal(dx_plane_init_for(&p, g, 0), 0);
        any_frame(&p, &rng);
        any_rules(&q, &variants[k % N_VARIANTS], &rng);
        t = smoothed(g, &q, &p);
        dx_sigma_init(&sigma, q.sigma, (double)g->unit_m);
        for (size_t m = 0; m < dx_plane_n_dexels(&p); m++) {
            const uint32_t range = dx_plane_range(dx_terrain_published(t), m);
            const double move = (double)range - dx_plane_range(&p, m);

            assert_int_equal(range != 0, dx_plane_range(&p, m) != 0);
            assert_true(fabs(move) <=
                        3 * dx_sigma_at(&sigma, dx_plane_range(&p, m)) / 256.0 + 0.51);
        }
        dx_terrain_free(t);
        dx_plane_fini(&p);
        dx_geometry_unref(g);
    }
}

/* Two noisy walls, one behind the other, with a step along a crooked line: what is behind moves the
 * wall in front by nothing. */
static void nothing_crosses_a_cut(void **state)
{
    const struct variant first_order = {.diag = DX_DIAG_FIXED};
    struct dx_rng rng = dx_rng_init(7, 0);
    struct dx_terrain *t[2];
    struct dx_geometry *g = grid_of(GRID_TURN, 70, 90, &rng);
    struct dx_terrain_params q;
    struct dx_plane p;

    (void)state;
    use_variant(&q, &first_order); /* a rescue may look across */
    q.sigma_given = true;
    q.sigma[0] = NOISE * UNIT_M;
    assert_int_equal(dx_plane_init_for(&p, g, 0), 0);
    for (int k = 0; k < 2; k++) {
        rng = dx_rng_init(8, 0);
        for (size_t m = 0; m < dx_plane_n_dexels(&p); m++) {
            const bool behind = m % 90 > 40 + 7 * (m / 90 % 5);
            const uint32_t range = 4000 + dx_rng_below(&rng, 30);

            dx_plane_set_range(&p, m, behind ? range + 2000 + 500 * (uint32_t)k : range);
        }
        t[k] = smoothed(g, &q, &p);
    }
    for (size_t m = 0; m < dx_plane_n_dexels(&p); m++)
        if (m % 90 <= 40 + 7 * (m / 90 % 5))
            assert_int_equal(dx_plane_range(dx_terrain_published(t[0]), m),
                             dx_plane_range(dx_terrain_published(t[1]), m));
    dx_terrain_free(t[0]);
    dx_terrain_free(t[1]);
    dx_plane_fini(&p);
    dx_geometry_unref(g);
}

/* Two planes that meet: off the crease it is as flat as elsewhere, on it the samples stay within
 * the noise. */
static void a_crease_stays(void **state)
{
    struct dx_rng rng = dx_rng_init(9, 0);
    struct dx_geometry *g = grid_of(GRID_TURN, 80, 100, &rng);
    const double n[2][3] = {{0.2, 0, 0}, {0, 0.5, 0}};
    struct dx_plane truth, p;
    struct dx_terrain_params q;
    struct dx_terrain *t;

    (void)state;
    dx_terrain_params_default(&q);
    q.sigma_given = true;
    q.sigma[0] = NOISE * UNIT_M;
    assert_int_equal(dx_plane_init_for(&truth, g, 0), 0);
    assert_int_equal(dx_plane_init_for(&p, g, 0), 0);
    for (size_t k = 0; k < dx_plane_n_dexels(&p); k++) {
        double d[3], r;

        linear_direction(g, (int64_t)k, d);
        r = 1 / (fmax(dot(d, n[0]), dot(d, n[1])) * UNIT_M);
        dx_plane_set_range(&truth, k, (uint32_t)rint(r));
        dx_plane_set_range(&p, k, (uint32_t)rint(r + NOISE * dx_rng_normal(&rng)));
    }
    t = smoothed(g, &q, &p);
    assert_true(rms_apart(dx_terrain_published(t), &truth, 0) < 0.4 * NOISE);
    dx_terrain_free(t);
    t = smoothed(g, &q, &truth);
    assert_true(rms_apart(dx_terrain_published(t), &truth, 0) < 0.2 * NOISE);
    dx_terrain_free(t);
    dx_plane_fini(&p);
    dx_plane_fini(&truth);
    dx_geometry_unref(g);
}

/* A stray sample that is joined to all around it goes to where they agree it should be, as far as
 * it may; one with neighbours like it in its row is a ridge, and stays. */
static void strays_go_and_ridges_stay(void **state)
{
    struct dx_rng rng = dx_rng_init(10, 0);
    struct dx_geometry *g = grid_of(GRID_TURN, 40, 60, &rng);
    struct dx_terrain_params q;
    struct dx_terrain *t;
    struct dx_plane p;

    (void)state;
    dx_terrain_params_default(&q);
    q.sigma_given = true;
    q.sigma[0] = NOISE * UNIT_M;
    assert_int_equal(dx_plane_init_for(&p, g, 0), 0);
    for (size_t k = 0; k < dx_plane_n_dexels(&p); k++)
        dx_plane_set_range(&p, k, k / 60 == 30 ? 5045 : 5000);
    dx_plane_set_range(&p, 15 * 60 + 20, 5045);
    dx_plane_set_range(&p, 15 * 60 + 40, 5020);
    t = smoothed(g, &q, &p);
    assert_int_equal(dx_plane_range(dx_terrain_published(t), 15 * 60 + 20), 5045 - 3 * NOISE);
    assert_in_range(dx_plane_range(dx_terrain_published(t), 15 * 60 + 40), 5000, 5005);
    assert_in_range(dx_plane_range(dx_terrain_published(t), 15 * 60 + 22), 4999, 5001);
    for (uint32_t j = 4; j < 56; j++)
        assert_in_range(dx_plane_range(dx_terrain_published(t), 30 * 60 + j), 5035, 5045);
    dx_terrain_free(t);
    dx_plane_fini(&p);
    dx_geometry_unref(g);
}

static void exact_points_are_not_smoothed(void **state)
{
    struct dx_terrain_params q;

    (void)state;
    dx_terrain_params_default(&q);
    assert_null(dx_terrain_params_check_exact(&q));
    q.smooth = true;
    assert_null(dx_terrain_params_check(&q));
    assert_non_null(dx_terrain_params_check_exact(&q));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_kernel_equals_the_definition),
        cmocka_unit_test(the_mesh_is_that_of_the_smoothed_array),
        cmocka_unit_test(planes_stay_and_noise_goes),
        cmocka_unit_test(no_sample_goes_far),
        cmocka_unit_test(nothing_crosses_a_cut),
        cmocka_unit_test(a_crease_stays),
        cmocka_unit_test(strays_go_and_ridges_stay),
        cmocka_unit_test(exact_points_are_not_smoothed),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
