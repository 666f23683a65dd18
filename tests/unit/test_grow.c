/* Growing: closed surfaces come out closed, rims stay, and whatever the points are the mesh is a
 * manifold of one orientation. Small random clouds look for what nobody thought of. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "core/base/rng.h"
#include "core/cloud/grow.h"
#include "drivers/synth/surfaces.h"
#include "halfedge_check.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

struct grown {
    struct dx_cloud cloud;
    struct dx_halfedges mesh;
    struct dx_grow_stats stats;
    struct halfedge_counts counts;
};

static void grow(struct grown *g, const double *xyz, size_t n, const struct dx_grow_config *config)
{
    struct dx_neighbours nb;
    const char *wrong;

    assert_int_equal(dx_cloud_init(&g->cloud, xyz, n, NULL, NULL), 0);
    assert_int_equal(dx_neighbours_init(&nb, &g->cloud, DX_GROW_K, NULL, NULL), 0);
    assert_int_equal(dx_grow(&g->mesh, &g->stats, &g->cloud, &nb, config, NULL), 0);
    dx_neighbours_fini(&nb);
    wrong = halfedge_check(&g->mesh);
    if (wrong)
        fail_msg("%s", wrong);
    g->counts = halfedge_count(&g->mesh);
    assert_int_equal(g->stats.n_triangles, g->mesh.n_faces);
    assert_int_equal(g->stats.n_border, g->counts.n_border);
    assert_int_equal(g->stats.n_unused, g->cloud.n - g->counts.n_used);
}

static void fini(struct grown *g)
{
    dx_cloud_fini(&g->cloud);
    dx_halfedges_fini(&g->mesh);
}

static void closed_surfaces_are_closed(void **state)
{
    static const enum dx_surface surfaces[] = {DX_SURFACE_SPHERE, DX_SURFACE_BUMPY,
                                               DX_SURFACE_TORUS, DX_SURFACE_DOUBLE_TORUS,
                                               DX_SURFACE_NESTED};
    struct dx_grow_config config;

    (void)state;
    dx_grow_defaults(&config);
    for (size_t k = 0; k < 5; k++)
        for (int j = 0; j < 3; j++) {
            const struct dx_surface_config c = {surfaces[k], 3000, 0.15 * j, 0, 8, 7};
            struct dx_surface_points p;
            struct grown g;

            assert_int_equal(dx_surface_sample(&p, &c), 0);
            grow(&g, p.xyz, p.n, &config);
            if (g.counts.n_border || g.counts.n_used + 3 < p.n ||
                g.counts.euler != dx_surface_euler(surfaces[k]))
                fail_msg("%s, jitter %g: %u border edges, %u of %u points, characteristic %lld",
                         dx_surface_name(surfaces[k]), c.jitter, g.counts.n_border, g.counts.n_used,
                         p.n, (long long)g.counts.euler);
            assert_int_equal(g.stats.n_components, surfaces[k] == DX_SURFACE_NESTED ? 2 : 1);
            fini(&g);
            free(p.xyz);
        }
}

static void rims_stay(void **state)
{
    static const enum dx_surface surfaces[] = {DX_SURFACE_PARABOLOID, DX_SURFACE_CYLINDER};
    struct dx_grow_config config;

    (void)state;
    dx_grow_defaults(&config);
    for (size_t k = 0; k < 2; k++) {
        const struct dx_surface_config c = {surfaces[k], 3000, 0.1, 0, 4, 7};
        struct dx_surface_points p;
        struct grown g;

        assert_int_equal(dx_surface_sample(&p, &c), 0);
        grow(&g, p.xyz, p.n, &config);
        assert_int_equal(g.counts.n_loops, dx_surface_n_rims(surfaces[k]));
        assert_int_equal(g.counts.euler, dx_surface_euler(surfaces[k]));
        fini(&g);
        free(p.xyz);
    }
}

/* The outside out, unless a viewpoint inside says otherwise. */
static void triangles_face_away(void **state)
{
    static const double inside[3] = {0};
    const struct dx_surface_config c = {DX_SURFACE_SPHERE, 2000, 0.2, 0, 4, 7};
    struct dx_surface_points p;
    struct dx_grow_config config;

    (void)state;
    dx_grow_defaults(&config);
    assert_int_equal(dx_surface_sample(&p, &c), 0);
    for (int k = 0; k < 2; k++) {
        struct grown g;

        config.viewpoint = k ? inside : NULL;
        grow(&g, p.xyz, p.n, &config);
        for (uint32_t f = 0; f < g.mesh.n_faces; f++) {
            const uint32_t h = g.mesh.face[f];
            const double *a = p.xyz + 3 * (size_t)g.cloud.index[dx_halfedge_from(&g.mesh, h)];
            const double *b = p.xyz + 3 * (size_t)g.cloud.index[g.mesh.of[h].to];
            const double *d = p.xyz + 3 * (size_t)g.cloud.index[dx_halfedge_apex(&g.mesh, h)];
            const double six = a[0] * (b[1] * d[2] - b[2] * d[1]) +
                               a[1] * (b[2] * d[0] - b[0] * d[2]) +
                               a[2] * (b[0] * d[1] - b[1] * d[0]);

            assert_true(k ? six < 0 : six > 0);
        }
        fini(&g);
    }
    free(p.xyz);
}

/* A point on a plane grid, in a small box, near a sphere: with equal distances and without. */
static void draw_point(double p[3], struct dx_rng *g, uint32_t kind)
{
    double len = 0;

    for (int i = 0; i < 3; i++) {
        p[i] = 2 * dx_rng_unit(g) - 1;
        len += p[i] * p[i];
    }
    for (int i = 0; i < 3; i++) {
        if (kind == 0)
            p[i] = i == 2 ? 0 : floor(4 * p[i]);
        else if (kind == 1)
            p[i] = floor(2 * p[i]);
        else if (kind == 2)
            p[i] *= (1 + 0.2 * dx_rng_unit(g)) / sqrt(len);
        else if (kind == 3)
            p[i] *= i == 0 ? 1 : 1e-3; /* nearly a line */
    }
}

static void any_cloud_makes_a_manifold(void **state)
{
    double xyz[3 * 80];

    (void)state;
    for (uint64_t seed = 0; seed < 1500; seed++) {
        struct dx_rng r = dx_rng_init(seed, 5);
        const uint32_t n = dx_rng_below(&r, 80), kind = dx_rng_below(&r, 5);
        struct dx_grow_config config;
        struct grown g;

        for (uint32_t k = 0; k < n; k++)
            draw_point(xyz + 3 * k, &r, kind);
        dx_grow_defaults(&config);
        config.max_ratio = 2 + 8 * dx_rng_unit(&r);
        config.max_loop = dx_rng_below(&r, 2) ? 0 : DX_GROW_MAX_LOOP;
        grow(&g, xyz, n, &config);
        fini(&g);
    }
}

static void a_square_grid_is_filled(void **state)
{
    struct dx_grow_config config;
    double xyz[3 * 400];
    struct grown g;

    (void)state;
    for (uint32_t k = 0; k < 400; k++) {
        const uint32_t row = k / 20, col = k % 20;

        xyz[3 * k] = col;
        xyz[3 * k + 1] = row;
        xyz[3 * k + 2] = 7;
    }
    dx_grow_defaults(&config);
    grow(&g, xyz, 400, &config);
    assert_int_equal(g.stats.n_triangles, 2 * 19 * 19);
    assert_int_equal(g.counts.n_border, 4 * 19);
    fini(&g);
}

static void parameters_are_checked(void **state)
{
    struct dx_grow_config bad[6];
    const struct dx_neighbours nb = {0};
    struct dx_cloud c;

    (void)state;
    assert_int_equal(dx_cloud_init(&c, NULL, 0, NULL, NULL), 0);
    for (size_t k = 0; k < 6; k++)
        dx_grow_defaults(&bad[k]);
    bad[0].bend_deg = 0;
    bad[1].bend_step_deg = 0.01;
    bad[2].max_angle_deg = 200;
    bad[3].max_ratio = 1;
    bad[4].max_loop = DX_GROW_MAX_LOOP + 1;
    bad[5].max_lean_deg = 91;
    for (size_t k = 0; k < 6; k++) {
        struct dx_err err = {""};
        struct dx_grow_stats stats;
        struct dx_halfedges m;

        assert_int_equal(dx_grow(&m, &stats, &c, &nb, &bad[k], &err), -EINVAL);
        assert_non_null(strstr(err.text, "expected"));
    }
    dx_cloud_fini(&c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closed_surfaces_are_closed), cmocka_unit_test(rims_stay),
        cmocka_unit_test(triangles_face_away),        cmocka_unit_test(any_cloud_makes_a_manifold),
        cmocka_unit_test(a_square_grid_is_filled),    cmocka_unit_test(parameters_are_checked),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
