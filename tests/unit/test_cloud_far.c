/* Strays far from a cloud: dexels stay small, neighbours and mesh are what they are without. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "cloud_fixture.h"
#include "core/base/rng.h"
#include "core/cloud/bulk.h"
#include "core/cloud/dexels.h"

#include <math.h>

#define N        6000
#define N_STRAYS 5

/* Points of the unit cube, then strays at this distance and at none. */
static void draw(double *xyz, double far)
{
    struct dx_rng g = dx_rng_init(11, 0);

    for (uint32_t k = 0; k < 3 * N; k++)
        xyz[k] = dx_rng_unit(&g);
    for (uint32_t k = 3 * (N - N_STRAYS); k < 3 * N; k++)
        xyz[k] = far * (dx_rng_unit(&g) - 0.5);
}

static uint32_t fullest(const struct dx_cloud *c)
{
    uint32_t most = 0;

    for (uint32_t d = 0; d < c->rows * c->cols; d++)
        if (c->start[d + 1] - c->start[d] > most)
            most = c->start[d + 1] - c->start[d];
    return most;
}

static void dexels_stay_small(void **state)
{
    static const double far[] = {1, 100, 1e4, 1e5};
    static double xyz[3 * N];

    (void)state;
    for (size_t k = 0; k < 4; k++) {
        struct dx_cloud c;

        draw(xyz, far[k]);
        assert_int_equal(dx_cloud_init(&c, xyz, N, NULL, NULL), 0);
        assert_int_equal(c.n, N);
        assert_in_range(c.rows * c.cols, N / 16, N);
        assert_true(fullest(&c) < 64);
        dx_cloud_fini(&c);
    }
}

/* Of strays and of points among the others; within small and large spheres. */
static void neighbours_are_those_of_brute_force(void **state)
{
    static struct dx_near near[DX_CLOUD_MAX_NEAREST], within[N];
    static double xyz[3 * N];
    struct dx_cloud c;

    (void)state;
    draw(xyz, 100);
    assert_int_equal(dx_cloud_init(&c, xyz, N, NULL, NULL), 0);
    for (uint32_t r = 0; r < c.n; r += c.index[r] + 100 < N ? 97 : 1) {
        uint32_t n_nearer = 0, n_within = 0;
        int64_t reach;
        int32_t radius;

        assert_int_equal(dx_cloud_nearest(&c, r, 12, near), 12);
        reach = near[11].d2;
        radius = (int32_t)sqrt((double)reach) + 1;
        for (uint32_t k = 0; k < c.n; k++) {
            int64_t d2 = 0;

            for (int i = 0; i < 3; i++)
                d2 += ((int64_t)c.at[k][i] - c.at[r][i]) * ((int64_t)c.at[k][i] - c.at[r][i]);
            n_nearer += k != r && d2 < reach;
            n_within += d2 <= (int64_t)radius * radius;
        }
        assert_true(n_nearer <= 11);
        assert_int_equal(dx_cloud_within(&c, c.at[r], radius, within, N), n_within);
    }
    dx_cloud_fini(&c);
}

static void the_bulk_leaves_strays_out(void **state)
{
    static int32_t at[2000][3];
    static uint32_t dexel[2000];
    struct dx_bulk b;

    (void)state;
    for (int32_t k = 0; k < 2000; k++) {
        at[k][0] = 1000 + k;
        at[k][1] = k == 7 ? 1 << 28 : k;
        at[k][2] = 5;
    }
    b = dx_bulk_find((const int32_t(*)[3])at, dexel, 2000, 0);
    assert_true(b.low == 1000 && b.high == 2999); /* nobody strays */
    b = dx_bulk_find((const int32_t(*)[3])at, dexel, 2000, 1);
    assert_true(b.low <= 2 && b.high >= 1997 && b.high < 4000);
    b = dx_bulk_find((const int32_t(*)[3])at, dexel, 2000, 2);
    assert_true(b.low == 5 && b.high == 5);
    dexel[7] = DX_DEXEL_NONE; /* not finite: it does not count */
    b = dx_bulk_find((const int32_t(*)[3])at, dexel, 2000, 1);
    assert_true(b.low == 0 && b.high == 1999);
}

/* A stray is alone, and what it does to the lattice does not matter. */
static void a_stray_leaves_the_mesh_closed(void **state)
{
    static const double far[] = {30, 1e3, 1e5};
    static struct soup soup;
    const struct dx_surface_config config = {DX_SURFACE_RANDOM_BUMPY, 20000, 0, 0, 0, 7};
    struct dx_project_config defaults;

    (void)state;
    dx_project_defaults(&defaults);
    for (size_t k = 0; k < 3; k++) {
        struct dx_surface_points p;
        struct dx_project_stats s;

        assert_int_equal(dx_surface_sample(&p, &config), 0);
        p.xyz = realloc(p.xyz, 3 * (p.n + 1) * sizeof(*p.xyz));
        assert_non_null(p.xyz);
        p.xyz[3 * p.n] = far[k];
        p.xyz[3 * p.n + 1] = p.xyz[3 * p.n + 2] = -far[k];
        s = project(&soup, p.xyz, p.n + 1, &defaults, NULL);
        assert_int_equal(s.n_isolated, 1);
        assert_int_equal(s.n_boundary, 0);
        assert_int_equal(soup_count(&soup, p.n + 1).euler, 2);
        free(p.xyz);
    }
}

/* So far that all others would be on one step of the lattice, or on a few; in several heaps. */
static void those_too_far_are_left_out(void **state)
{
    static const double far[] = {1e8, 1e12, 1e100};
    static double xyz[3 * N];

    (void)state;
    for (size_t k = 0; k < 3; k++) {
        struct dx_cloud c;

        draw(xyz, 1);
        for (uint32_t i = 0; i < 3; i++) {
            xyz[i] = far[k];
            xyz[3 * (N / 2) + i] = -far[k] * 1e4;
        }
        assert_int_equal(dx_cloud_init(&c, xyz, N, NULL, NULL), 0);
        assert_int_equal(c.n_strays, 2);
        assert_int_equal(c.n, N - 2);
        assert_int_equal(c.n_duplicates, 0);
        assert_true(c.step < 1e-8);
        for (uint32_t r = 0; r < c.n; r++)
            assert_true(c.index[r] != 0 && c.index[r] != N / 2);
        dx_cloud_fini(&c);
    }
}

/* No point is a stray of what is all in one place. */
static void equal_points_are_duplicates(void **state)
{
    static double xyz[3 * N];
    struct dx_cloud c;

    (void)state;
    for (uint32_t k = 0; k < 3 * N; k++)
        xyz[k] = k % 3;
    assert_int_equal(dx_cloud_init(&c, xyz, N, NULL, NULL), 0);
    assert_int_equal(c.n_duplicates, N - 1);
    assert_int_equal(c.n_strays, 0);
    dx_cloud_fini(&c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(dexels_stay_small),
        cmocka_unit_test(those_too_far_are_left_out),
        cmocka_unit_test(equal_points_are_duplicates),
        cmocka_unit_test(neighbours_are_those_of_brute_force),
        cmocka_unit_test(the_bulk_leaves_strays_out),
        cmocka_unit_test(a_stray_leaves_the_mesh_closed),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
