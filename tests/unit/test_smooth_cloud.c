/* Smoothing clouds: what noise and bias are left on a sphere, threads, odd input. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "core/base/rng.h"
#include "core/cloud/cloud_normals.h"
#include "core/cloud/smooth_cloud.h"
#include "drivers/synth/surfaces.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

struct smoothed {
    struct dx_cloud cloud;
    struct dx_cloud_smooth_scale scale;
    struct dx_cloud_smooth_stats stats;
    struct dx_cloud_smoothed *out;
};

static void smooth(struct smoothed *s, const double *xyz, size_t n,
                   const struct dx_cloud_smooth_config *config, struct dx_pool *pool)
{
    assert_int_equal(dx_cloud_init(&s->cloud, xyz, n, pool, NULL), 0);
    assert_int_equal(dx_cloud_smooth_find(&s->scale, &s->cloud, config, NULL), 0);
    s->out = malloc(s->cloud.n * sizeof(*s->out) + 1);
    assert_non_null(s->out);
    dx_cloud_smooth(s->out, &s->stats, &s->cloud, &s->scale, pool);
}

static void fini(struct smoothed *s)
{
    dx_cloud_fini(&s->cloud);
    free(s->out);
}

/* Root mean square of the distance from the unit sphere. */
static double rms_of_sphere(const struct smoothed *s)
{
    double sum = 0;

    for (uint32_t r = 0; r < s->cloud.n; r++) {
        double p[3], d;

        dx_cloud_to_input(p, &s->cloud, s->out[r].at);
        d = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) - 1;
        sum += d * d;
    }
    return sqrt(sum / s->cloud.n);
}

/* 5027 points: the radius is 20 spacings. */
static void noise_of_a_sphere_goes(void **state)
{
    static const enum dx_surface surfaces[] = {DX_SURFACE_SPHERE, DX_SURFACE_RANDOM_SPHERE};

    (void)state;
    for (size_t k = 0; k < 2; k++) {
        const struct dx_surface_config c = {surfaces[k], 5027, 0.3, 0.5, 4, 7};
        const struct dx_cloud_smooth_config plane = {0}, quadric = {.quadric = true};
        struct dx_surface_points p;
        struct smoothed s;

        assert_int_equal(dx_surface_sample(&p, &c), 0);
        smooth(&s, p.xyz, p.n, &plane, NULL);
        assert_true(fabs(s.scale.spacing * s.cloud.step - p.spacing) < 0.1 * p.spacing);
        assert_true(rms_of_sphere(&s) < 0.2 * p.spacing);
        fini(&s);
        smooth(&s, p.xyz, p.n, &quadric, NULL);
        assert_true(rms_of_sphere(&s) < 0.12 * p.spacing);
        for (uint32_t r = 0; r < s.cloud.n; r++) { /* normals are radial */
            double at[3], dot = 0, len = 0;
            float n[3];

            dx_cloud_to_input(at, &s.cloud, s.out[r].at);
            dx_cloud_normal_out(n, &s.cloud, s.out[r].normal);
            for (int i = 0; i < 3; i++) {
                dot += at[i] * (double)n[i];
                len += at[i] * at[i];
            }
            assert_true(fabs(dot) > 0.8 * sqrt(len));
        }
        fini(&s);
        free(p.xyz);
    }
}

/* A few points that belong to nothing change next to nothing of the others. */
static void stray_points_do_not_count(void **state)
{
    const struct dx_surface_config c = {DX_SURFACE_SPHERE, 5027, 0.3, 0.3, 4, 7};
    const struct dx_cloud_smooth_config config = {.sw = 1.5, .sr = 1};
    struct dx_rng g = dx_rng_init(1, 1);
    struct dx_surface_points p;
    struct smoothed s;
    double sum = 0;
    uint32_t n = 0;

    (void)state;
    assert_int_equal(dx_surface_sample(&p, &c), 0);
    for (uint32_t k = 0; k < p.n; k += 20) {
        const double out = 1 + p.spacing * (6 * dx_rng_unit(&g) - 3);

        for (int i = 0; i < 3; i++)
            p.xyz[3 * k + (uint32_t)i] *= out;
    }
    smooth(&s, p.xyz, p.n, &config, NULL);
    for (uint32_t r = 0; r < s.cloud.n; r++) {
        double at[3], d;

        if (s.cloud.index[r] % 20 == 0)
            continue;
        dx_cloud_to_input(at, &s.cloud, s.out[r].at);
        d = sqrt(at[0] * at[0] + at[1] * at[1] + at[2] * at[2]) - 1;
        sum += d * d;
        n++;
    }
    assert_true(sqrt(sum / n) < 0.2 * p.spacing);
    fini(&s);
    free(p.xyz);
}

/* All but what snapping to the lattice does. */
static void a_plane_is_kept(void **state)
{
    const struct dx_cloud_smooth_config config = {0};
    double xyz[3 * 40 * 40];
    struct smoothed s;

    (void)state;
    for (uint32_t k = 0; k < 40 * 40; k++) {
        const uint32_t row = k / 40, col = k % 40;

        xyz[3 * k] = col;
        xyz[3 * k + 1] = row;
        xyz[3 * k + 2] = 0.25 * col - 0.5 * row;
    }
    smooth(&s, xyz, 40 * 40, &config, NULL);
    assert_int_equal(s.stats.n_unchanged, 0);
    for (uint32_t r = 0; r < s.cloud.n; r++) {
        double p[3];

        dx_cloud_to_input(p, &s.cloud, s.out[r].at);
        for (uint32_t i = 0; i < 3; i++)
            assert_true(fabs(p[i] - xyz[3 * s.cloud.index[r] + i]) < 2 * s.cloud.step);
    }
    fini(&s);
}

static void threads_do_not_matter(void **state)
{
    static const unsigned counts[] = {1, 2, 3, 8};
    const struct dx_surface_config c = {DX_SURFACE_RANDOM_BUMPY, 8000, 0, 0.4, 4, 7};

    (void)state;
    for (int quadric = 0; quadric < 2; quadric++) {
        const struct dx_cloud_smooth_config config = {.quadric = quadric};
        struct dx_surface_points p;
        struct smoothed first, s;

        assert_int_equal(dx_surface_sample(&p, &c), 0);
        smooth(&first, p.xyz, p.n, &config, NULL);
        for (size_t k = 0; k < 4; k++) {
            struct dx_pool *pool;

            assert_int_equal(dx_pool_new(&pool, counts[k]), 0);
            smooth(&s, p.xyz, p.n, &config, pool);
            for (uint32_t r = 0; r < s.cloud.n; r++) {
                assert_memory_equal(s.out[r].at, first.out[r].at, sizeof(s.out[r].at));
                assert_memory_equal(s.out[r].normal, first.out[r].normal, sizeof(s.out[r].normal));
            }
            assert_memory_equal(&s.stats, &first.stats, sizeof(s.stats));
            fini(&s);
            dx_pool_free(pool);
        }
        fini(&first);
        free(p.xyz);
    }
}

/* Points without a plane stay; densities a thousand times apart and far coordinates do no harm. */
static void odd_input_is_taken(void **state)
{
    const struct dx_cloud_smooth_config config = {.quadric = true};
    static double xyz[3 * 4000];
    struct dx_rng g = dx_rng_init(3, 3);
    struct smoothed s;

    (void)state;
    for (size_t n = 0; n < 30; n++) {
        for (size_t k = 0; k < n; k++) /* a line */
            for (size_t i = 0; i < 3; i++)
                xyz[3 * k + i] = (double)(k * (i + 1));
        smooth(&s, xyz, n, &config, NULL);
        assert_int_equal(s.cloud.n, n);
        assert_int_equal(s.stats.n_unchanged, n);
        fini(&s);
    }
    for (size_t k = 0; k < 4000; k++) {
        const double size = k % 2 ? 1 : 1000;

        for (size_t i = 0; i < 2; i++)
            xyz[3 * k + i] = 1e12 + size * dx_rng_unit(&g);
        xyz[3 * k + 2] = 1e12 + 1e-3 * size * dx_rng_unit(&g);
    }
    smooth(&s, xyz, 4000, &config, NULL);
    for (uint32_t r = 0; r < s.cloud.n; r++)
        for (int i = 0; i < 3; i++)
            assert_true(isfinite(s.out[r].at[i]));
    fini(&s);
}

static void parameters_are_checked(void **state)
{
    const struct dx_cloud_smooth_config bad[] = {
        {.sw = 0.4}, {.sw = 5}, {.sw = NAN}, {.sr = 0.05}, {.sr = 11}};
    struct dx_cloud_smooth_scale scale;
    struct dx_cloud c;

    (void)state;
    assert_int_equal(dx_cloud_init(&c, NULL, 0, NULL, NULL), 0);
    for (size_t k = 0; k < sizeof(bad) / sizeof(*bad); k++) {
        struct dx_err err = {""};

        assert_int_equal(dx_cloud_smooth_find(&scale, &c, &bad[k], &err), -EINVAL);
        assert_non_null(strstr(err.text, "expected"));
    }
    dx_cloud_fini(&c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(noise_of_a_sphere_goes), cmocka_unit_test(stray_points_do_not_count),
        cmocka_unit_test(a_plane_is_kept),        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(odd_input_is_taken),     cmocka_unit_test(parameters_are_checked),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
