/* Neighbours of all points beside those of one; normals of analytic surfaces: near the true ones,
 * and all outside; the same for any order and number of threads. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "cloud_fixture.h"
#include "core/base/rng.h"
#include "core/cloud/cloud_normals.h"
#include "core/cloud/least_axis.h"

#include <errno.h>

static struct dx_surface_points sample(enum dx_surface surface, uint32_t n, double jitter,
                                       double noise)
{
    const struct dx_surface_config c = {surface, n, jitter, noise, 4, 7};
    struct dx_surface_points p;

    assert_int_equal(dx_surface_sample(&p, &c), 0);
    return p;
}

/* Normals in the axes and the order of the input. */
struct normals {
    float (*n)[3];
    struct dx_cloud_normals_stats stats;
};

static struct normals normals_of(const double *xyz, uint32_t n, const double *viewpoint,
                                 struct dx_pool *pool)
{
    struct dx_cloud_normals_config config;
    struct normals out;
    struct dx_cloud c;
    float(*by_rank)[3];

    assert_int_equal(dx_cloud_init(&c, xyz, n, pool, NULL), 0);
    by_rank = calloc(n + 1, sizeof(*by_rank));
    out.n = calloc(n + 1, sizeof(*out.n));
    assert_non_null(by_rank);
    assert_non_null(out.n);
    dx_cloud_normals_defaults(&config);
    config.viewpoint = viewpoint;
    assert_int_equal(dx_cloud_normals(by_rank, NULL, &out.stats, &c, NULL, &config, pool, NULL), 0);
    for (uint32_t r = 0; r < c.n; r++)
        dx_cloud_normal_out(out.n[c.index[r]], &c, by_rank[r]);
    free(by_rank);
    dx_cloud_fini(&c);
    return out;
}

static double dot(const float n[3], const double p[3])
{
    return (double)n[0] * p[0] + (double)n[1] * p[1] + (double)n[2] * p[2];
}

/* ---- neighbours ----------------------------------------------------------------------------- */

static void expect_neighbours(const double *xyz, uint32_t n, uint32_t k)
{
    struct dx_neighbours nb;
    struct dx_cloud c;

    assert_int_equal(dx_cloud_init(&c, xyz, n, NULL, NULL), 0);
    assert_int_equal(dx_neighbours_init(&nb, &c, k, NULL, NULL), 0);
    assert_int_equal(nb.k, k < c.n ? k : c.n - 1);
    for (uint32_t r = 0; r < c.n; r++) {
        struct dx_near near[DX_CLOUD_MAX_NEAREST];

        assert_int_equal(dx_cloud_nearest(&c, r, k, near), nb.k);
        for (uint32_t i = 0; i < nb.k; i++)
            assert_int_equal(dx_neighbours_of(&nb, r)[i], near[i].rank);
    }
    dx_neighbours_fini(&nb);
    dx_cloud_fini(&c);
}

/* Grids have equal distances; clusters far apart have spheres that hold all or nothing. */
static void all_neighbours_are_those_of_each(void **state)
{
    static const enum dx_surface surfaces[] = {DX_SURFACE_TORUS, DX_SURFACE_RANDOM_SPHERE};
    double odd[3 * 600];
    struct dx_rng g = dx_rng_init(1, 0);

    (void)state;
    for (size_t s = 0; s < 2; s++) {
        struct dx_surface_points p = sample(surfaces[s], 5000, 0, 0);

        expect_neighbours(p.xyz, p.n, 16);
        expect_neighbours(p.xyz, p.n, 1);
        free(p.xyz);
    }
    for (uint32_t k = 0; k < 600; k++)
        for (uint32_t i = 0; i < 3; i++)
            odd[3 * k + i] = k % 3 * 1e3 + dx_rng_unit(&g) * (k % 3 == 1 ? 1e-4 : 1);
    expect_neighbours(odd, 600, 64);
    expect_neighbours(odd, 20, 64);
    expect_neighbours(odd, 2, 5);
}

static void few_points_have_few_neighbours(void **state)
{
    const double one[3] = {1, 2, 3};
    struct dx_neighbours nb;
    struct dx_cloud c;

    (void)state;
    assert_int_equal(dx_cloud_init(&c, one, 1, NULL, NULL), 0);
    assert_int_equal(dx_neighbours_init(&nb, &c, 0, NULL, NULL), -EINVAL);
    assert_int_equal(dx_neighbours_init(&nb, &c, 65, NULL, NULL), -EINVAL);
    assert_int_equal(dx_neighbours_init(&nb, &c, 5, NULL, NULL), 0);
    assert_int_equal(nb.k, 0);
    dx_neighbours_fini(&nb);
    dx_cloud_fini(&c);
}

/* ---- planes --------------------------------------------------------------------------------- */

/* Of random covariances, flat ones among them: the axis that rotations find. */
static void least_axis_is_an_eigenvector(void **state)
{
    struct dx_rng g = dx_rng_init(2, 0);

    (void)state;
    for (int t = 0; t < 20000; t++) {
        struct dx_sym3 s = {{0}};
        struct dx_eigen3 e;
        double axis[3], share, along = 0;

        for (int k = 0; k < 8; k++) {
            double p[3];

            for (int i = 0; i < 3; i++)
                p[i] = dx_rng_unit(&g) - 0.5;
            p[2] *= t % 3 == 0 ? 0 : t % 3 == 1 ? 1e-5 : 0.7;
            for (int i = 0, m = 0; i < 3; i++)
                for (int j = i; j < 3; j++, m++)
                    s.m[m] += p[i] * p[j];
        }
        dx_sym3_eigen(&e, &s);
        assert_true(dx_least_axis(axis, &share, &s));
        if (e.value[1] - e.value[0] < 0.01 * e.value[2])
            continue;
        for (int i = 0; i < 3; i++)
            along += axis[i] * e.vector[0][i];
        assert_true(fabs(along) > 1 - 1e-9 && fabs(along) < 1 + 1e-9);
        along = share * (s.m[0] + s.m[3] + s.m[5]) - e.value[0];
        assert_true(fabs(along) < 1e-9 * e.value[2]);
    }
}

static void lines_have_no_least_axis(void **state)
{
    const struct dx_sym3 none = {{0}}, line = {{1, 2, 3, 4, 6, 9}};
    double axis[3], share;

    (void)state;
    assert_false(dx_least_axis(axis, &share, &none));
    assert_false(dx_least_axis(axis, &share, &line));
}

/* ---- sides ---------------------------------------------------------------------------------- */

/* The direction that is out of the surface and nearly its normal: spheres with and without bumps
 * are seen from their middle, tori from the circle in their tube. */
static void outwards(double out[3], enum dx_surface surface, const double p[3])
{
    const double r = sqrt(p[0] * p[0] + p[1] * p[1]);
    const bool torus = surface == DX_SURFACE_TORUS || surface == DX_SURFACE_RANDOM_TORUS;

    for (int k = 0; k < 3; k++)
        out[k] = p[k] - (torus && k < 2 ? p[k] / r : 0);
}

static void normals_point_out(void **state)
{
    static const struct {
        enum dx_surface surface;
        double noise, least; /* spacings; cosine to what is out */
    } cases[] = {
        {DX_SURFACE_SPHERE, 0, 0.99},        {DX_SURFACE_CUBED_SPHERE, 0, 0.99},
        {DX_SURFACE_TORUS, 0, 0.99},         {DX_SURFACE_RANDOM_SPHERE, 0, 0.9},
        {DX_SURFACE_RANDOM_TORUS, 0, 0.9},   {DX_SURFACE_BUMPY, 0, 0.5},
        {DX_SURFACE_RANDOM_BUMPY, 0, 0.4},   {DX_SURFACE_NESTED, 0, 0.9},
        {DX_SURFACE_RANDOM_BUMPY, 0.4, 0.1}, {DX_SURFACE_RANDOM_TORUS, 0.4, 0},
    };

    (void)state;
    for (size_t s = 0; s < sizeof(cases) / sizeof(*cases); s++) {
        struct dx_surface_points p = sample(cases[s].surface, 20000, 0.2, cases[s].noise);
        struct normals out = normals_of(p.xyz, p.n, NULL, NULL);

        assert_int_equal(out.stats.n_parts, cases[s].surface == DX_SURFACE_NESTED ? 2 : 1);
        assert_int_equal(out.stats.n_undefined, 0);
        for (uint32_t k = 0; k < p.n; k++) {
            double d[3], c;

            outwards(d, cases[s].surface, p.xyz + 3 * k);
            c = dot(out.n[k], d) / sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
            if (!(c > cases[s].least && c < 1 + 1e-6))
                fail_msg("case %zu, point %u: cosine %g", s, k, c);
        }
        free(out.n);
        free(p.xyz);
    }
}

static void normals_face_the_viewpoint(void **state)
{
    const double inside[3] = {0.1, -0.2, 0.1};
    struct dx_surface_points p = sample(DX_SURFACE_RANDOM_SPHERE, 5000, 0, 0);
    struct normals out = normals_of(p.xyz, p.n, inside, NULL);

    (void)state;
    for (uint32_t k = 0; k < p.n; k++)
        assert_true(dot(out.n[k], p.xyz + 3 * k) < 0);
    free(out.n);
    free(p.xyz);
}

/* Two sheets that are nearer than many of the neighbours: edges between them, whose normals are
 * parallel too, must not tell sides. At the rims planes are fitted to both. */
static void sheets_that_are_near_keep_their_sides(void **state)
{
    enum { SIDE = 60, SHEET = SIDE * SIDE, RIM = 3 };
    double *xyz = malloc(sizeof(*xyz) * 3 * 2 * SHEET);
    struct dx_rng g = dx_rng_init(3, 0);
    struct normals out;

    (void)state;
    assert_non_null(xyz);
    for (uint32_t k = 0; k < 2 * SHEET; k++) {
        const uint32_t i = k % SHEET / SIDE, j = k % SIDE;

        xyz[3 * k] = i + 0.3 * dx_rng_unit(&g);
        xyz[3 * k + 1] = j + 0.3 * dx_rng_unit(&g);
        xyz[3 * k + 2] = k < SHEET ? 0 : 2;
    }
    out = normals_of(xyz, 2 * SHEET, NULL, NULL);
    for (uint32_t k = 0; k < 2 * SHEET; k++) {
        const uint32_t i = k % SHEET / SIDE, j = k % SIDE;
        const uint32_t middle = k / SHEET * SHEET + SHEET / 2 + SIDE / 2;

        if (i >= RIM && i < SIDE - RIM && j >= RIM && j < SIDE - RIM)
            assert_true(out.n[k][2] * out.n[middle][2] > 0);
    }
    free(out.n);
    free(xyz);
}

static void clouds_without_planes_have_no_normals(void **state)
{
    double line[3 * 100] = {0};
    struct normals out;

    (void)state;
    for (int k = 0; k < 100; k++)
        line[3 * k] = line[3 * k + 1] = k;
    out = normals_of(line, 100, NULL, NULL);
    assert_int_equal(out.stats.n_undefined, 100);
    assert_int_equal(out.stats.n_parts, 0);
    for (int k = 0; k < 100; k++)
        assert_true(out.n[k][0] == 0 && out.n[k][1] == 0 && out.n[k][2] == 0);
    free(out.n);
    for (uint32_t n = 0; n < 3; n++) {
        out = normals_of(line, n, NULL, NULL);
        assert_int_equal(out.stats.n_undefined, n);
        free(out.n);
    }
}

static void order_and_threads_do_not_matter(void **state)
{
    static const unsigned counts[] = {1, 2, 3, 8};
    struct dx_surface_points p = sample(DX_SURFACE_RANDOM_BUMPY, 30000, 0, 0.3);
    struct normals first = normals_of(p.xyz, p.n, NULL, NULL), out;
    double *back = malloc(3 * p.n * sizeof(*back));

    (void)state;
    assert_non_null(back);
    for (size_t k = 0; k < 4; k++) {
        struct dx_pool *pool;

        assert_int_equal(dx_pool_new(&pool, counts[k]), 0);
        out = normals_of(p.xyz, p.n, NULL, pool);
        assert_memory_equal(out.n, first.n, p.n * sizeof(*out.n));
        free(out.n);
        dx_pool_free(pool);
    }
    for (uint32_t k = 0; k < p.n; k++)
        memcpy(back + 3 * k, p.xyz + 3 * (p.n - 1 - k), 3 * sizeof(*back));
    out = normals_of(back, p.n, NULL, NULL);
    for (uint32_t k = 0; k < p.n; k++)
        assert_memory_equal(out.n[k], first.n[p.n - 1 - k], sizeof(*out.n));
    free(out.n);
    free(first.n);
    free(back);
    free(p.xyz);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_neighbours_are_those_of_each),
        cmocka_unit_test(few_points_have_few_neighbours),
        cmocka_unit_test(least_axis_is_an_eigenvector),
        cmocka_unit_test(lines_have_no_least_axis),
        cmocka_unit_test(normals_point_out),
        cmocka_unit_test(normals_face_the_viewpoint),
        cmocka_unit_test(sheets_that_are_near_keep_their_sides),
        cmocka_unit_test(clouds_without_planes_have_no_normals),
        cmocka_unit_test(order_and_threads_do_not_matter),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
