/* The localized Delaunay mesh on analytic surfaces: closed ones come out closed, whatever the
 * sampling; all come out manifold and consistently oriented, whatever the noise. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "delaunay_fixture.h"

#define K 16

static struct soup soup;

static struct dx_surface_points sample(enum dx_surface surface, uint32_t n, double jitter,
                                       double noise)
{
    return surface_points(&(struct dx_surface_config){surface, n, jitter, noise, 4, 7});
}

static struct dx_delaunay_config defaults(void)
{
    struct dx_delaunay_config config;

    dx_delaunay_defaults(&config);
    return config;
}

static const double jitters[] = {0, 0.1, 0.2, 0.3};

static void closed_surfaces_are_closed(void **state)
{
    static const struct {
        enum dx_surface surface;
        uint32_t n;
    } cases[] = {
        {DX_SURFACE_SPHERE, 12837}, {DX_SURFACE_CUBED_SPHERE, 12502},
        {DX_SURFACE_BUMPY, 20021},  {DX_SURFACE_TORUS, 16864},
        {DX_SURFACE_NESTED, 12000}, {DX_SURFACE_DOUBLE_TORUS, 8000},
        {DX_SURFACE_PLATE, 12000},
    };
    const struct dx_delaunay_config config = defaults();

    (void)state;
    for (size_t k = 0; k < sizeof(cases) / sizeof(*cases); k++)
        for (size_t j = 0; j < 4; j++) {
            struct dx_surface_points p = sample(cases[k].surface, cases[k].n, jitters[j], 0);

            delaunay(&soup, p.xyz, p.n, &config, K, NULL);
            expect_closed(&soup, p.xyz, p.n, dx_surface_euler(cases[k].surface));
            free(p.xyz);
        }
}

/* Independent points: pairs that nearly meet, gaps of several spacings. Nearly all triangles are
 * what all three corners find. */
static void random_samples_are_closed(void **state)
{
    static const enum dx_surface surfaces[] = {DX_SURFACE_RANDOM_SPHERE, DX_SURFACE_RANDOM_BUMPY,
                                               DX_SURFACE_RANDOM_TORUS};
    const struct dx_delaunay_config config = defaults();

    (void)state;
    for (size_t k = 0; k < 3; k++) {
        struct dx_surface_points p = sample(surfaces[k], 37974, 0, 0);
        struct dx_delaunay_stats s = delaunay(&soup, p.xyz, p.n, &config, K, NULL);

        expect_closed(&soup, p.xyz, p.n, dx_surface_euler(surfaces[k]));
        assert_true(100 * s.n_by_votes[3] > 99 * soup.n);
        assert_in_range(s.n_widened, p.n / 10, p.n / 2);
        free(p.xyz);
    }
}

/* Each triangle of a sphere faces away from its middle: nothing is folded. */
static void the_sphere_faces_out(void **state)
{
    struct dx_surface_points p = sample(DX_SURFACE_SPHERE, 20000, 0.3, 0);
    const struct dx_delaunay_config config = defaults();
    double six = 0;

    (void)state;
    delaunay(&soup, p.xyz, p.n, &config, K, NULL);
    for (size_t k = 0; k < soup.n; k++) {
        const double *a = p.xyz + 3 * (size_t)soup.v[3 * k],
                     *b = p.xyz + 3 * (size_t)soup.v[3 * k + 1],
                     *c = p.xyz + 3 * (size_t)soup.v[3 * k + 2];
        const double of_one = a[0] * (b[1] * c[2] - b[2] * c[1]) +
                              a[1] * (b[2] * c[0] - b[0] * c[2]) +
                              a[2] * (b[0] * c[1] - b[1] * c[0]);

        assert_true(of_one > 0);
        six += of_one;
    }
    assert_true(six / 6 > 4.18 && six / 6 < 4.1888);
    free(p.xyz);
}

static void open_surfaces_keep_their_rims(void **state)
{
    static const enum dx_surface surfaces[] = {DX_SURFACE_PARABOLOID, DX_SURFACE_CYLINDER};
    const struct dx_delaunay_config config = defaults();

    (void)state;
    for (size_t k = 0; k < 2; k++)
        for (size_t j = 0; j < 4; j++) {
            struct dx_surface_points p = sample(surfaces[k], 10000, jitters[j], 0);
            struct dx_delaunay_stats s = delaunay(&soup, p.xyz, p.n, &config, K, NULL);
            struct soup_counts c = soup_count(&soup, p.n);

            assert_int_equal(c.euler, dx_surface_euler(surfaces[k]));
            assert_int_equal(c.n_points, p.n);
            assert_int_equal(s.n_boundary, c.n_boundary); /* each rim is a simple loop */
            assert_in_range(c.n_boundary, 100, 600);
            free(p.xyz);
        }
}

/* As shadows, with normals of more neighbours, noisy points make next to no hole; in any case the
 * mesh is a manifold. */
static void noise_leaves_a_manifold(void **state)
{
    static const struct {
        double noise;
        uint32_t k;
        uint64_t n_boundary;
    } cases[] = {{0.1, 24, 20}, {0.4, 48, 100}, {1, 64, 600}, {3, 64, UINT64_MAX}};
    struct dx_delaunay_config config = defaults();

    (void)state;
    config.shadow = true;
    for (size_t k = 0; k < 4; k++) {
        struct dx_surface_points p = sample(DX_SURFACE_RANDOM_BUMPY, 20000, 0, cases[k].noise);
        struct soup_counts c;

        config.k = cases[k].k;
        delaunay(&soup, p.xyz, p.n, &config, cases[k].k, NULL);
        c = soup_count(&soup, p.n);
        if (c.n_boundary > cases[k].n_boundary)
            fail_msg("noise %g: %llu boundary edges", cases[k].noise,
                     (unsigned long long)c.n_boundary);
        if (cases[k].noise < 1)
            assert_true(c.n_points > p.n * 0.999);
        free(p.xyz);
    }
}

/* The paper's own radius makes a manifold too; circles close what it leaves open. */
static void the_papers_radius_makes_a_manifold(void **state)
{
    struct dx_delaunay_config config = defaults();

    (void)state;
    config.paper_radius = true;
    for (size_t j = 0; j < 4; j++) {
        struct dx_surface_points p = sample(DX_SURFACE_BUMPY, 20021, jitters[j], 0);

        delaunay(&soup, p.xyz, p.n, &config, K, NULL);
        expect_closed(&soup, p.xyz, p.n, 2);
        free(p.xyz);
    }
    struct dx_surface_points p = sample(DX_SURFACE_RANDOM_BUMPY, 20021, 0, 0);

    delaunay(&soup, p.xyz, p.n, &config, K, NULL);
    assert_true(soup_count(&soup, p.n).n_points > p.n * 0.99);
    free(p.xyz);
}

/* A sphere without a cap; how many points are left. */
static uint32_t cut_cap(struct dx_surface_points *p, double radius)
{
    uint32_t n = 0;

    for (uint32_t k = 0; k < p->n; k++) {
        const double *q = p->xyz + 3 * k;

        if (q[0] * q[0] + q[1] * q[1] > radius * radius || q[2] < 0)
            memmove(p->xyz + 3 * n++, q, 3 * sizeof(*q));
    }
    return n;
}

/* A hole of fifteen spacings stays; one of ten, which a point's candidates may be sought across, is
 * closed if wider circles are allowed. */
static void large_holes_stay(void **state)
{
    struct dx_surface_points p = sample(DX_SURFACE_SPHERE, 8000, 0.2, 0);
    struct dx_delaunay_config config = defaults();
    struct soup_counts c;
    uint32_t n;

    (void)state;
    n = cut_cap(&p, 5 * p.spacing);
    config.widest = 8;
    delaunay(&soup, p.xyz, n, &config, K, NULL);
    expect_closed(&soup, p.xyz, n, 2);
    n = cut_cap(&p, 7.5 * p.spacing);
    config = defaults();
    delaunay(&soup, p.xyz, n, &config, K, NULL);
    c = soup_count(&soup, n);
    assert_int_equal(c.euler, 1);
    assert_in_range(c.n_boundary, 15, 60);
    free(p.xyz);
}

/* Turned into planes, noisy points disagree often enough to leave holes. */
static void small_holes_are_filled(void **state)
{
    struct dx_surface_points p = sample(DX_SURFACE_RANDOM_SPHERE, 30000, 0, 0.2);
    struct dx_delaunay_config config = defaults();
    struct dx_delaunay_stats s;
    uint64_t n_open;

    (void)state;
    config.max_loop = 0;
    delaunay(&soup, p.xyz, p.n, &config, K, NULL);
    n_open = soup_count(&soup, p.n).n_boundary;
    config.max_loop = 8;
    s = delaunay(&soup, p.xyz, p.n, &config, K, NULL);
    assert_true(n_open > 50 && s.n_loop_triangles > 20);
    assert_true(soup_count(&soup, p.n).n_boundary < n_open / 4);
    free(p.xyz);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closed_surfaces_are_closed),
        cmocka_unit_test(random_samples_are_closed),
        cmocka_unit_test(the_sphere_faces_out),
        cmocka_unit_test(open_surfaces_keep_their_rims),
        cmocka_unit_test(noise_leaves_a_manifold),
        cmocka_unit_test(the_papers_radius_makes_a_manifold),
        cmocka_unit_test(large_holes_stay),
        cmocka_unit_test(small_holes_are_filled),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
