/* Clusters and the points that represent them: every point in one cluster, bounds kept, threads. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "core/cloud/reduce.h"
#include "core/cloud/spacing.h"
#include "core/cloud/sym3.h"
#include "drivers/synth/surfaces.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static void load(struct dx_cloud *c, enum dx_surface surface, uint32_t n, double noise)
{
    const struct dx_surface_config config = {surface, n, 0, noise, 4, 7};
    struct dx_surface_points p;

    assert_int_equal(dx_surface_sample(&p, &config), 0);
    assert_int_equal(dx_cloud_init(c, p.xyz, p.n, NULL, NULL), 0);
    free(p.xyz);
}

static double extent(const struct dx_cloud *c, const struct dx_clusters *cl, uint32_t k)
{
    double most = 0;

    for (uint32_t i = cl->start[k]; i < cl->start[k + 1]; i++)
        for (uint32_t j = cl->start[k]; j < i; j++) {
            double d2 = 0;

            for (int a = 0; a < 3; a++) {
                const double d = c->at[cl->member[i]][a] - c->at[cl->member[j]][a];

                d2 += d * d;
            }
            most = d2 > most ? d2 : most;
        }
    return sqrt(most);
}

static void clusters_part_the_cloud(void **state)
{
    struct dx_cluster_config config;
    struct dx_clusters cl;
    struct dx_cloud c;
    uint8_t *seen;

    (void)state;
    load(&c, DX_SURFACE_RANDOM_BUMPY, 10000, 0.2);
    seen = calloc(c.n, 1);
    dx_cluster_defaults(&config);
    assert_int_equal(dx_clusters_init(&cl, &c, &config, NULL, NULL), 0);
    assert_true(cl.n > 100);
    assert_int_equal(cl.start[0], 0);
    assert_int_equal(cl.start[cl.n], c.n);
    for (uint32_t k = 0; k < cl.n; k++) {
        const uint32_t n = cl.start[k + 1] - cl.start[k];

        assert_in_range(n, 1, config.max_points);
        for (uint32_t i = cl.start[k]; i < cl.start[k + 1]; i++) {
            assert_true(i == cl.start[k] || cl.member[i - 1] < cl.member[i]);
            assert_int_equal(seen[cl.member[i]]++, 0);
        }
    }
    dx_clusters_fini(&cl);
    dx_cloud_fini(&c);
    free(seen);
}

/* What is cut for its variation is flat in the end, or small. */
static void clusters_are_flat(void **state)
{
    struct dx_cluster_config config;
    struct dx_clusters cl;
    struct dx_cloud c;

    (void)state;
    load(&c, DX_SURFACE_TORUS, 20000, 0);
    dx_cluster_defaults(&config);
    config.max_points = 0;
    assert_int_equal(dx_clusters_init(&cl, &c, &config, NULL, NULL), 0);
    assert_in_range(cl.n, 20, 2000);
    for (uint32_t k = 0; k < cl.n; k++) {
        const uint32_t n = cl.start[k + 1] - cl.start[k];
        double mean[3] = {0};
        struct dx_sym3 s = {{0}};
        struct dx_eigen3 e;

        for (uint32_t i = cl.start[k]; i < cl.start[k + 1]; i++)
            for (int a = 0; a < 3; a++)
                mean[a] += (double)c.at[cl.member[i]][a] / n;
        for (uint32_t i = cl.start[k]; i < cl.start[k + 1]; i++)
            for (int a = 0, m = 0; a < 3; a++)
                for (int b = a; b < 3; b++, m++)
                    s.m[m] += (c.at[cl.member[i]][a] - mean[a]) * (c.at[cl.member[i]][b] - mean[b]);
        dx_sym3_eigen(&e, &s);
        assert_true(n <= config.min_points ||
                    e.value[0] <= 0.0101 * (e.value[0] + e.value[1] + e.value[2]));
    }
    dx_clusters_fini(&cl);
    dx_cloud_fini(&c);
}

/* The paper's plane parts the points above a sheet from those below: clusters that reach far. */
static void the_printed_split_makes_shells(void **state)
{
    double mean[2] = {0};
    struct dx_cloud c;

    (void)state;
    load(&c, DX_SURFACE_SPHERE, 4000, 0.1);
    for (int k = 0; k < 2; k++) {
        struct dx_cluster_config config;
        struct dx_clusters cl;

        dx_cluster_defaults(&config);
        config.split = k ? DX_CLUSTER_FLAT : DX_CLUSTER_ACROSS;
        config.max_points = 0;
        assert_int_equal(dx_clusters_init(&cl, &c, &config, NULL, NULL), 0);
        for (uint32_t i = 0; i < cl.n; i++)
            mean[k] += extent(&c, &cl, i) / cl.n;
        dx_clusters_fini(&cl);
    }
    assert_true(mean[1] > 1.5 * mean[0]);
    dx_cloud_fini(&c);
}

static void threads_do_not_matter(void **state)
{
    static const unsigned counts[] = {1, 2, 3, 8};
    const struct dx_cloud_smooth_config smooth = {0};
    struct dx_cloud_smooth_scale scale;
    struct dx_cluster_config config;
    struct dx_clusters first, cl;
    struct dx_reduced r1, r;
    struct dx_cloud c;

    (void)state;
    load(&c, DX_SURFACE_RANDOM_BUMPY, 20000, 0.3);
    dx_cluster_defaults(&config);
    assert_int_equal(dx_cloud_smooth_find(&scale, &c, &smooth, NULL), 0);
    assert_int_equal(dx_clusters_init(&first, &c, &config, NULL, NULL), 0);
    assert_int_equal(dx_reduce(&r1, &c, &first, &scale, NULL, NULL), 0);
    for (size_t k = 0; k < 4; k++) {
        struct dx_pool *pool;

        assert_int_equal(dx_pool_new(&pool, counts[k]), 0);
        assert_int_equal(dx_clusters_init(&cl, &c, &config, pool, NULL), 0);
        assert_int_equal(cl.n, first.n);
        assert_memory_equal(cl.start, first.start, (cl.n + 1) * sizeof(*cl.start));
        assert_memory_equal(cl.member, first.member, c.n * sizeof(*cl.member));
        assert_int_equal(dx_reduce(&r, &c, &cl, &scale, pool, NULL), 0);
        assert_int_equal(r.n, r1.n);
        assert_memory_equal(r.xyz, r1.xyz, r.n * sizeof(*r.xyz));
        assert_memory_equal(r.normal, r1.normal, r.n * sizeof(*r.normal));
        dx_reduced_fini(&r);
        dx_clusters_fini(&cl);
        dx_pool_free(pool);
    }
    dx_reduced_fini(&r1);
    dx_clusters_fini(&first);
    dx_cloud_fini(&c);
}

static void representatives_are_on_the_surface(void **state)
{
    const struct dx_surface_config noisy = {DX_SURFACE_SPHERE, 20000, 0.3, 0.4, 4, 7};
    const struct dx_cloud_smooth_config smooth = {.quadric = true};
    struct dx_cloud_smooth_scale scale;
    struct dx_cluster_config config;
    struct dx_surface_points p;
    struct dx_clusters cl;
    struct dx_reduced r;
    struct dx_cloud c;
    double sum = 0;

    (void)state;
    assert_int_equal(dx_surface_sample(&p, &noisy), 0);
    assert_int_equal(dx_cloud_init(&c, p.xyz, p.n, NULL, NULL), 0);
    assert_int_equal(dx_cloud_smooth_find(&scale, &c, &smooth, NULL), 0);
    dx_cluster_defaults(&config);
    assert_int_equal(dx_clusters_init(&cl, &c, &config, NULL, NULL), 0);
    assert_int_equal(dx_reduce(&r, &c, &cl, &scale, NULL, NULL), 0);
    assert_int_equal(r.n + r.n_merged, cl.n);
    for (uint32_t k = 0; k < r.n; k++) {
        double len = 0;

        for (int i = 0; i < 3; i++)
            len += r.xyz[k][i] * r.xyz[k][i];
        sum += (sqrt(len) - 1) * (sqrt(len) - 1);
    }
    assert_true(sqrt(sum / r.n) < 0.15 * p.spacing);
    dx_reduced_fini(&r);
    dx_clusters_fini(&cl);
    dx_cloud_fini(&c);
    free(p.xyz);
}

static void odd_input_is_taken(void **state)
{
    double xyz[3 * 300];

    (void)state;
    for (size_t n = 0; n < 300; n += n < 20 ? 1 : 93)
        for (int line = 0; line < 2; line++) {
            const struct dx_cloud_smooth_config smooth = {0};
            struct dx_cloud_smooth_scale scale;
            struct dx_cluster_config config;
            struct dx_clusters cl;
            struct dx_reduced r;
            struct dx_cloud c;

            for (size_t k = 0; k < n; k++) /* one place, a line */
                for (size_t i = 0; i < 3; i++)
                    xyz[3 * k + i] = line ? (double)(k * (i + 1)) : 1;
            assert_int_equal(dx_cloud_init(&c, xyz, n, NULL, NULL), 0);
            dx_cluster_defaults(&config);
            assert_int_equal(dx_clusters_init(&cl, &c, &config, NULL, NULL), 0);
            assert_int_equal(dx_cloud_smooth_find(&scale, &c, &smooth, NULL), 0);
            assert_int_equal(dx_reduce(&r, &c, &cl, &scale, NULL, NULL), 0);
            assert_true((n == 0) == (r.n == 0));
            for (uint32_t k = 0; k < r.n; k++)
                for (int i = 0; i < 3; i++)
                    assert_true(isfinite(r.xyz[k][i]));
            dx_reduced_fini(&r);
            dx_clusters_fini(&cl);
            dx_cloud_fini(&c);
        }
}

static void parameters_are_checked(void **state)
{
    const struct dx_cluster_config bad[] = {
        {DX_CLUSTER_ACROSS, 0, 8, 64},
        {DX_CLUSTER_ACROSS, NAN, 8, 64},
        {DX_CLUSTER_ACROSS, 0.01, 0, 64},
        {DX_CLUSTER_ACROSS, 0.01, 8, 7},
    };
    struct dx_cloud c;

    (void)state;
    load(&c, DX_SURFACE_SPHERE, 100, 0);
    for (size_t k = 0; k < sizeof(bad) / sizeof(*bad); k++) {
        struct dx_err err = {""};
        struct dx_clusters cl;

        assert_int_equal(dx_clusters_init(&cl, &c, &bad[k], NULL, &err), -EINVAL);
        assert_non_null(strstr(err.text, "expected"));
    }
    dx_cloud_fini(&c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(clusters_part_the_cloud),
        cmocka_unit_test(clusters_are_flat),
        cmocka_unit_test(the_printed_split_makes_shells),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(representatives_are_on_the_surface),
        cmocka_unit_test(odd_input_is_taken),
        cmocka_unit_test(parameters_are_checked),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
