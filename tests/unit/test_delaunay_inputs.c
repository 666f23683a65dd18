/* The localized Delaunay mesh of clouds that are not as it assumes: too few points, none in a
 * plane, far from the origin, uneven, in two sheets; the order of the input and threads; its
 * parameters. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "delaunay_fixture.h"
#include "odd_clouds.h"

#include <errno.h>
#include <math.h>

#define K 16

static struct soup soup;

static struct dx_delaunay_config defaults(void)
{
    struct dx_delaunay_config config;

    dx_delaunay_defaults(&config);
    return config;
}

static struct dx_surface_points sample(enum dx_surface surface, uint32_t n, double jitter,
                                       double gap)
{
    return surface_points(&(struct dx_surface_config){surface, n, jitter, 0, gap, 3});
}

static void too_few_points_make_no_mesh(void **state)
{
    const double xyz[] = {0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0, 4, 0, 0, 5, 0, 0};
    const double equal[] = {1, 2, 3, 1, 2, 3, 1, 2, 3, 1, 2, 3};
    const double odd[] = {NAN, 0, 0, 0, INFINITY, 0, 1, 1, -INFINITY, 1, 2, 3};
    const struct dx_delaunay_config config = defaults();

    (void)state;
    for (size_t n = 0; n <= 6; n++) { /* all on a line, too */
        delaunay(&soup, xyz, n, &config, K, NULL);
        assert_int_equal(soup.n, 0);
    }
    delaunay(&soup, equal, 4, &config, K, NULL);
    assert_int_equal(soup.n, 0);
    delaunay(&soup, odd, 4, &config, K, NULL);
    assert_int_equal(soup.n, 0);
}

static void three_points_make_a_triangle(void **state)
{
    const double xyz[] = {0, 0, 0, 1, 0, 0, 0.5, 0.8, 0};
    const struct dx_delaunay_config config = defaults();

    (void)state;
    delaunay(&soup, xyz, 3, &config, K, NULL);
    assert_int_equal(soup.n, 1);
    assert_int_equal(soup_count(&soup, 3).n_boundary, 3);
}

static void a_plane_grid_is_filled(void **state)
{
    const struct dx_delaunay_config config = defaults();
    const uint32_t side = 60;

    (void)state;
    for (int tilted = 0; tilted < 2; tilted++) {
        double *xyz = odd_plane_grid(side, tilted);
        struct dx_delaunay_stats s;
        struct soup_counts c;

        s = delaunay(&soup, xyz, side * side, &config, K, NULL);
        c = soup_count(&soup, side * side);
        assert_int_equal(c.n_points, side * side);
        assert_int_equal(c.euler, 1);
        assert_int_equal(c.n_boundary, 4 * (side - 1));
        assert_int_equal(soup.n, 2 * (side - 1) * (side - 1));
        if (!tilted) /* the lowest rank decides for all four of a square */
            assert_int_equal(s.n_by_votes[3], soup.n);
        free(xyz);
    }
}

static void place_and_size_do_not_matter(void **state)
{
    static const double scale[] = {1, 1e12, 1e-12, 1e100}, shift[] = {0, 1e12, 0, 1e101};
    const struct dx_delaunay_config config = defaults();

    (void)state;
    for (size_t k = 0; k < 4; k++) {
        struct dx_surface_points p = sample(DX_SURFACE_BUMPY, 5000, 0.2, 0);

        for (uint32_t i = 0; i < 3 * p.n; i++)
            p.xyz[i] = p.xyz[i] * scale[k] + shift[k];
        delaunay(&soup, p.xyz, p.n, &config, K, NULL);
        expect_closed(&soup, p.xyz, p.n, 2);
        free(p.xyz);
    }
}

/* The triangles are those of the points, not of the axes (invariant G3): but for near ties, which
 * the lattice decides. */
static void turning_it_changes_few_triangles(void **state)
{
    struct dx_surface_points p = sample(DX_SURFACE_BUMPY, 20000, 0.3, 0);
    const struct dx_delaunay_config config = defaults();
    struct soup moved = {0};

    (void)state;
    delaunay(&soup, p.xyz, p.n, &config, K, NULL);
    odd_move(p.xyz, p.n);
    delaunay(&moved, p.xyz, p.n, &config, K, NULL);
    soup_sort(&soup);
    soup_sort(&moved);
    assert_int_equal(moved.n, soup.n);
    assert_in_range(soup_missing(&soup, &moved), 0, 2);
    free(moved.v);
    free(p.xyz);
}

/* A double has steps of 1.2e-4 there, the spacing is 0.05. */
static void far_away_the_lattice_is_coarse(void **state)
{
    const struct dx_delaunay_config config = defaults();
    struct dx_surface_points p = sample(DX_SURFACE_SPHERE, 5000, 0.2, 0);

    (void)state;
    for (uint32_t i = 0; i < 3 * p.n; i++)
        p.xyz[i] = 1e12 + p.xyz[i];
    delaunay(&soup, p.xyz, p.n, &config, K, NULL);
    expect_closed(&soup, p.xyz, p.n, 2);
    free(p.xyz);
}

static void two_sheets_stay_apart_or_manifold(void **state)
{
    static const double gaps[] = {0, 0.3, 0.8, 2, 3}; /* spacings */
    const struct dx_delaunay_config config = defaults();

    (void)state;
    for (size_t k = 0; k < 5; k++) {
        struct dx_surface_points p = sample(DX_SURFACE_NESTED, 8000, 0.1, gaps[k]);

        delaunay(&soup, p.xyz, p.n, &config, K, NULL);
        soup_count(&soup, p.n); /* manifold in any case */
        if (gaps[k] == 3)
            expect_closed(&soup, p.xyz, p.n, 4);
        free(p.xyz);
    }
}

static void density_may_change(void **state)
{
    const struct dx_delaunay_config config = defaults();
    const uint32_t n = 20000;
    double *xyz = odd_uneven_sphere(n);

    (void)state;
    delaunay(&soup, xyz, n, &config, K, NULL);
    assert_true(soup_count(&soup, n).n_points > n * 0.99);
    free(xyz);
}

static void what_is_no_surface_ends(void **state)
{
    const struct dx_delaunay_config config = defaults();
    const uint32_t n = 4000;
    struct dx_rng g = dx_rng_init(9, 0);

    (void)state;
    for (int clustered = 0; clustered < 2; clustered++) {
        double *xyz = odd_volume(n, clustered, &g);

        delaunay(&soup, xyz, n, &config, K, NULL);
        soup_count(&soup, n);
        free(xyz);
    }
}

/* Points of a small grid, of a line and a few others, of sheets that cross, of clusters. */
static void draw_odd(double *xyz, uint32_t n, int kind, struct dx_rng *g)
{
    for (uint32_t k = 0; k < n; k++) {
        double *p = xyz + 3 * k;

        for (int i = 0; i < 3; i++)
            p[i] = dx_rng_unit(g);
        if (kind == 0)
            for (int i = 0; i < 3; i++)
                p[i] = floor(4 * p[i]);
        if (kind == 1 && k > 5)
            p[1] = p[2] = p[0];
        if (kind == 2)
            p[2] = k % 2 ? p[0] : 1 - p[0];
        if (kind == 3)
            for (int i = 0; i < 3; i++)
                p[i] = k % 7 + pow(10, -(double)(k % 7)) * p[i];
    }
}

static void small_odd_clouds_make_manifolds(void **state)
{
    struct dx_rng g = dx_rng_init(10, 0);
    size_t n_triangles = 0;

    (void)state;
    for (int t = 0; t < 1500; t++) {
        const uint32_t n = 1 + dx_rng_below(&g, 150), k = 3 + dx_rng_below(&g, 20);
        struct dx_delaunay_config config = defaults();
        double xyz[3 * 150];

        config.k = k;
        config.shadow = t % 2;
        config.paper_radius = t % 7 == 0;
        config.widest = t % 3 ? 2.5 : 100;
        config.max_loop = dx_rng_below(&g, DX_DELAUNAY_MAX_LOOP + 1);
        draw_odd(xyz, n, t % 5, &g);
        delaunay(&soup, xyz, n, &config, k, NULL);
        soup_count(&soup, n);
        n_triangles += soup.n;
    }
    assert_true(n_triangles > 10000);
}

static void order_and_threads_do_not_matter(void **state)
{
    static const unsigned counts[] = {1, 2, 3, 8};
    const struct dx_surface_config noisy = {DX_SURFACE_RANDOM_BUMPY, 40000, 0, 0.2, 0, 6};
    const struct dx_delaunay_config config = defaults();
    struct dx_surface_points p;
    uint64_t hash;

    (void)state;
    assert_int_equal(dx_surface_sample(&p, &noisy), 0);
    delaunay(&soup, p.xyz, p.n, &config, K, NULL);
    hash = soup_hash(&soup);
    for (size_t k = 0; k < 4; k++) {
        struct dx_pool *pool;

        assert_int_equal(dx_pool_new(&pool, counts[k]), 0);
        delaunay(&soup, p.xyz, p.n, &config, K, pool);
        assert_int_equal(soup_hash(&soup), hash);
        dx_pool_free(pool);
    }
    for (uint32_t k = 0; k < p.n / 2; k++) { /* backwards: the same triangles of the same points */
        double held[3];

        memcpy(held, p.xyz + 3 * k, sizeof(held));
        memcpy(p.xyz + 3 * k, p.xyz + 3 * (p.n - 1 - k), sizeof(held));
        memcpy(p.xyz + 3 * (p.n - 1 - k), held, sizeof(held));
    }
    delaunay(&soup, p.xyz, p.n, &config, K, NULL);
    for (size_t k = 0; k < 3 * soup.n; k++)
        soup.v[k] = p.n - 1 - soup.v[k];
    assert_int_equal(soup_hash(&soup), hash);
    free(p.xyz);
}

static void bits_are_golden(void **state)
{
    struct dx_surface_points p = sample(DX_SURFACE_RANDOM_BUMPY, 20000, 0, 0);
    const struct dx_delaunay_config config = defaults();

    (void)state;
    delaunay(&soup, p.xyz, p.n, &config, K, NULL);
    if (soup_hash(&soup) != 0x99e6cc9832e83e4f)
        fail_msg("the mesh is 0x%016llx", (unsigned long long)soup_hash(&soup));
    free(p.xyz);
}

static void no_edge_is_longer_than_asked(void **state)
{
    struct dx_surface_points p = sample(DX_SURFACE_RANDOM_SPHERE, 5000, 0, 0);
    struct dx_delaunay_config config = defaults();
    const double most = 1.5 * p.spacing;

    (void)state;
    config.max_loop = 0;
    config.max_edge = most;
    delaunay(&soup, p.xyz, p.n, &config, K, NULL);
    assert_true(soup.n > p.n / 2);
    for (size_t k = 0; k < 3 * soup.n; k++) {
        const double *a = p.xyz + 3 * (size_t)soup.v[k];
        const double *b = p.xyz + 3 * (size_t)soup.v[k % 3 == 2 ? k - 2 : k + 1];

        assert_true((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                        (a[2] - b[2]) * (a[2] - b[2]) <
                    most * most * 1.0001);
    }
    free(p.xyz);
}

static void parameters_have_ranges(void **state)
{
    struct soup none = {0};
    const struct dx_delaunay_sink sink = {soup_take, NULL, &none};
    struct dx_delaunay_config bad[7];
    struct dx_surface_points p = sample(DX_SURFACE_SPHERE, 1000, 0, 0);
    struct dx_delaunay_stats s;
    struct dx_err err;
    struct bed bed;

    (void)state;
    bed_init(&bed, p.xyz, p.n, K, NULL, NULL);
    for (int k = 0; k < 7; k++)
        bad[k] = defaults();
    bad[0].widest = 0.5;
    bad[1].widest = NAN;
    bad[2].max_edge = -1;
    bad[3].max_loop = DX_DELAUNAY_MAX_LOOP + 1;
    bad[4].least_m = 6;
    bad[5].k = 2;
    bad[6].k = 65;
    for (int k = 0; k < 7; k++) {
        assert_int_equal(dx_delaunay(&s, &bed.cloud, &bed.nb, (const float(*)[3])bed.normals,
                                     &bad[k], &sink, NULL, &err),
                         -EINVAL);
        assert_non_null(strstr(err.text, "expected"));
    }
    assert_int_equal(none.n, 0);
    bed_fini(&bed);
    free(p.xyz);
}

static int refuse(void *ctx, const uint32_t v[3])
{
    (void)v;
    return --*(int *)ctx < 0 ? -ENOSPC : 0;
}

static void the_sink_can_stop_it(void **state)
{
    struct dx_surface_points p = sample(DX_SURFACE_RANDOM_SPHERE, 2000, 0, 0);
    const struct dx_delaunay_config config = defaults();
    struct dx_delaunay_stats s;
    struct bed bed;

    (void)state;
    bed_init(&bed, p.xyz, p.n, K, NULL, NULL);
    for (int left = 0; left < 4000; left += 1333) {
        int n = left;
        const struct dx_delaunay_sink sink = {refuse, NULL, &n};

        assert_int_equal(dx_delaunay(&s, &bed.cloud, &bed.nb, (const float(*)[3])bed.normals,
                                     &config, &sink, NULL, NULL),
                         left < 3996 ? -ENOSPC : 0);
    }
    bed_fini(&bed);
    free(p.xyz);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(too_few_points_make_no_mesh),
        cmocka_unit_test(three_points_make_a_triangle),
        cmocka_unit_test(a_plane_grid_is_filled),
        cmocka_unit_test(place_and_size_do_not_matter),
        cmocka_unit_test(turning_it_changes_few_triangles),
        cmocka_unit_test(far_away_the_lattice_is_coarse),
        cmocka_unit_test(two_sheets_stay_apart_or_manifold),
        cmocka_unit_test(density_may_change),
        cmocka_unit_test(what_is_no_surface_ends),
        cmocka_unit_test(small_odd_clouds_make_manifolds),
        cmocka_unit_test(order_and_threads_do_not_matter),
        cmocka_unit_test(bits_are_golden),
        cmocka_unit_test(no_edge_is_longer_than_asked),
        cmocka_unit_test(parameters_have_ranges),
        cmocka_unit_test(the_sink_can_stop_it),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
