/* The projection-based mesh on analytic surfaces: closed ones come out closed, whatever the
 * sampling; all come out manifold and consistently oriented. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "cloud_fixture.h"

static struct soup soup;

static struct dx_surface_points sample(enum dx_surface surface, uint32_t n, double jitter,
                                       double noise)
{
    return surface_points(&(struct dx_surface_config){surface, n, jitter, noise, 4, 7});
}

static const double jitters[] = {0, 0.1, 0.2, 0.3};

static void closed_surfaces_are_closed(void **state)
{
    static const struct {
        enum dx_surface surface;
        uint32_t n;
    } cases[] = {
        {DX_SURFACE_SPHERE, 12772}, {DX_SURFACE_CUBED_SPHERE, 12502},
        {DX_SURFACE_BUMPY, 20021},  {DX_SURFACE_TORUS, 16864},
        {DX_SURFACE_NESTED, 12000}, {DX_SURFACE_DOUBLE_TORUS, 8000},
        {DX_SURFACE_PLATE, 12000},
    };
    struct dx_project_config config;

    (void)state;
    dx_project_defaults(&config);
    for (size_t k = 0; k < sizeof(cases) / sizeof(*cases); k++)
        for (size_t j = 0; j < 4; j++) {
            struct dx_surface_points p = sample(cases[k].surface, cases[k].n, jitters[j], 0);
            struct dx_project_stats s = project(&soup, p.xyz, p.n, &config, NULL);

            expect_closed(&soup, p.xyz, p.n, dx_surface_euler(cases[k].surface));
            assert_int_equal(s.n_components, cases[k].surface == DX_SURFACE_NESTED ? 2 : 1);
            free(p.xyz);
        }
}

/* Independent points: pairs that nearly meet, gaps of several spacings. */
static void random_samples_are_closed(void **state)
{
    static const enum dx_surface surfaces[] = {DX_SURFACE_RANDOM_SPHERE, DX_SURFACE_RANDOM_BUMPY,
                                               DX_SURFACE_RANDOM_TORUS};
    struct dx_project_config config;

    (void)state;
    dx_project_defaults(&config);
    for (size_t k = 0; k < 3; k++) {
        struct dx_surface_points p = sample(surfaces[k], 37974, 0, 0);

        project(&soup, p.xyz, p.n, &config, NULL);
        expect_closed(&soup, p.xyz, p.n, dx_surface_euler(surfaces[k]));
        free(p.xyz);
    }
}

static double volume(const struct soup *s, const double *xyz)
{
    double six = 0;

    for (size_t k = 0; k < s->n; k++) {
        const double *a = xyz + 3 * (size_t)s->v[3 * k], *b = xyz + 3 * (size_t)s->v[3 * k + 1],
                     *c = xyz + 3 * (size_t)s->v[3 * k + 2];

        six += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
               a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    return six / 6;
}

/* The mesh is the sphere, with its outside out: nothing is folded or crosses. */
static void the_sphere_is_filled(void **state)
{
    struct dx_surface_points p = sample(DX_SURFACE_SPHERE, 20000, 0.3, 0);
    struct dx_project_config config;

    (void)state;
    dx_project_defaults(&config);
    project(&soup, p.xyz, p.n, &config, NULL);
    for (size_t k = 0; k < soup.n; k++) { /* star-shaped: each triangle faces away */
        struct soup one = {soup.v + 3 * k, 1, 1};

        assert_true(volume(&one, p.xyz) > 0);
    }
    assert_true(volume(&soup, p.xyz) > 4.18 && volume(&soup, p.xyz) < 4.1888);
    free(p.xyz);
}

static void open_surfaces_keep_their_rims(void **state)
{
    static const enum dx_surface surfaces[] = {DX_SURFACE_PARABOLOID, DX_SURFACE_CYLINDER};
    struct dx_project_config config;

    (void)state;
    dx_project_defaults(&config);
    for (size_t k = 0; k < 2; k++)
        for (size_t j = 0; j < 4; j++) {
            struct dx_surface_points p = sample(surfaces[k], 10000, jitters[j], 0);
            struct dx_project_stats s = project(&soup, p.xyz, p.n, &config, NULL);
            struct soup_counts c = soup_count(&soup, p.n);

            assert_int_equal(c.euler, dx_surface_euler(surfaces[k]));
            assert_int_equal(c.n_points, p.n);
            assert_int_equal(s.n_boundary, c.n_boundary); /* each rim is a simple loop */
            assert_in_range(c.n_boundary, 100, 600);
            free(p.xyz);
        }
}

/* The last triangle of a hole may complete its corners, and another ear of the same point must not
 * be made then. */
static void holes_in_noise_leave_a_manifold(void **state)
{
    const struct dx_surface_config noisy = {DX_SURFACE_RANDOM_BUMPY, 20000, 0, 2, 0, 6};
    struct dx_project_config config;
    struct dx_surface_points p;

    (void)state;
    dx_project_defaults(&config);
    assert_int_equal(dx_surface_sample(&p, &noisy), 0);
    assert_true(project(&soup, p.xyz, p.n, &config, NULL).n_loop_triangles > 100);
    soup_count(&soup, p.n);
    free(p.xyz);
}

static void noise_leaves_a_manifold(void **state)
{
    static const double noises[] = {0.1, 0.4, 1, 3};
    struct dx_project_config config;

    (void)state;
    dx_project_defaults(&config);
    for (size_t k = 0; k < 4; k++) {
        struct dx_surface_points p = sample(DX_SURFACE_RANDOM_BUMPY, 20000, 0, noises[k]);
        struct soup_counts c;

        project(&soup, p.xyz, p.n, &config, NULL);
        c = soup_count(&soup, p.n);
        if (noises[k] < 0.5) /* next to no hole */
            assert_true(c.n_boundary < 100 && c.n_points > 19800);
        free(p.xyz);
    }
}

static void all_choices_and_planes_make_manifolds(void **state)
{
    struct dx_project_config config;

    (void)state;
    dx_project_defaults(&config);
    for (int choice = 0; choice < 3; choice++)
        for (int plane = 0; plane < 3; plane++)
            for (size_t j = 0; j < 4; j += 3) {
                struct dx_surface_points p = sample(DX_SURFACE_TORUS, 8000, jitters[j], 0.1);
                struct soup_counts c;

                config.choice = (enum dx_project_choice)choice;
                config.plane = (enum dx_project_plane)plane;
                project(&soup, p.xyz, p.n, &config, NULL);
                c = soup_count(&soup, p.n);
                assert_true(c.n_boundary < 40 && c.n_points > p.n - 40);
                free(p.xyz);
            }
}

/* The paper's angle criterion does what it is there for. */
static void beta_avoids_sharp_triangles(void **state)
{
    struct dx_surface_points p = sample(DX_SURFACE_SPHERE, 8000, 0.3, 0);
    struct dx_project_config config;
    size_t n_sharp[2];

    (void)state;
    dx_project_defaults(&config);
    for (int k = 0; k < 2; k++) {
        config.choice = k ? DX_PROJECT_BETA : DX_PROJECT_NEXT;
        project(&soup, p.xyz, p.n, &config, NULL);
        n_sharp[k] = 0;
        for (size_t i = 0; i < 3 * soup.n; i++) {
            const double *a = p.xyz + 3 * (size_t)soup.v[i];
            const double *b = p.xyz + 3 * (size_t)soup.v[i % 3 == 2 ? i - 2 : i + 1];
            const double *c = p.xyz + 3 * (size_t)soup.v[i % 3 == 0 ? i + 2 : i - 1];
            double bb = 0, cc = 0, bc = 0;

            for (int d = 0; d < 3; d++) {
                bb += (b[d] - a[d]) * (b[d] - a[d]);
                cc += (c[d] - a[d]) * (c[d] - a[d]);
                bc += (b[d] - a[d]) * (c[d] - a[d]);
            }
            n_sharp[k] += bc > 0 && bc * bc > 0.9698 * bb * cc; /* 10 degrees */
        }
    }
    assert_true(n_sharp[1] < n_sharp[0] * 2 / 3);
    free(p.xyz);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closed_surfaces_are_closed),
        cmocka_unit_test(random_samples_are_closed),
        cmocka_unit_test(the_sphere_is_filled),
        cmocka_unit_test(open_surfaces_keep_their_rims),
        cmocka_unit_test(noise_leaves_a_manifold),
        cmocka_unit_test(holes_in_noise_leave_a_manifold),
        cmocka_unit_test(all_choices_and_planes_make_manifolds),
        cmocka_unit_test(beta_avoids_sharp_triangles),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
