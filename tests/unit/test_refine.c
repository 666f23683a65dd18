/* The stages in turn: each leaves a sound mesh (M4), refining brings it to the surface, threads do
 * not count, and any cloud is taken. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "core/base/hash.h"
#include "core/base/rng.h"
#include "core/cloud/smooth_stages.h"
#include "drivers/synth/surfaces.h"
#include "halfedge_check.h"

#include <errno.h>
#include <math.h>
#include <string.h>

#define N_PASSES 3

struct run {
    struct dx_stages s;
    struct dx_grow_stats grown;
    struct dx_refine_stats refined[N_PASSES];
    uint32_t max_points;
    double tolerance;
};

static void expect_sound(const struct dx_stages *s)
{
    const char *wrong = halfedge_check(&s->mesh.edges);

    if (wrong)
        fail_msg("%s", wrong);
    assert_int_equal(halfedge_count(&s->mesh.edges).n_corners, 0);
    for (uint32_t v = 0; v < s->mesh.edges.n_vertices; v++)
        for (int k = 0; k < 3; k++)
            assert_true(isfinite(s->mesh.at[v][k]));
}

static void run_all(struct run *r, const double *xyz, size_t n, struct dx_pool *pool, bool at_once,
                    bool reduce)
{
    const struct dx_cloud_smooth_config smooth = {0};
    struct dx_cloud_smooth_scale scale;
    struct dx_cloud_smooth_stats stats;
    struct dx_cluster_config cluster;
    struct dx_refine_config refine;
    struct dx_grow_config grow;

    dx_cluster_defaults(&cluster);
    dx_grow_defaults(&grow);
    dx_refine_defaults(&refine);
    cluster.max_points = r->max_points;
    cluster.min_points = cluster.min_points < r->max_points ? cluster.min_points : r->max_points;
    refine.tolerance = r->tolerance;
    assert_int_equal(dx_stages_init(&r->s, xyz, n, pool, NULL), 0);
    if (!at_once)
        assert_int_equal(dx_stages_smooth(&r->s, &scale, &stats, &smooth, NULL), 0);
    if (reduce) {
        assert_int_equal(dx_stages_cluster(&r->s, &cluster, NULL), 0);
        assert_int_equal(dx_stages_reduce(&r->s, NULL), 0);
    }
    assert_int_equal(dx_stages_grow(&r->s, &r->grown, &grow, NULL), 0);
    expect_sound(&r->s);
    for (int k = 0; k < N_PASSES; k++) {
        assert_int_equal(dx_stages_refine(&r->s, &r->refined[k], &refine, NULL), 0);
        expect_sound(&r->s);
    }
}

/* Root mean square from the unit sphere, of the middles of triangles. */
static double rms_of_sphere(const struct dx_stages *s)
{
    const struct dx_halfedges *m = &s->mesh.edges;
    double sum = 0;

    for (uint32_t f = 0; f < m->n_faces; f++) {
        const uint32_t h = m->face[f];
        const double *v[3] = {s->mesh.at[dx_halfedge_from(m, h)], s->mesh.at[m->of[h].to],
                              s->mesh.at[dx_halfedge_apex(m, h)]};
        double mean[3], p[3], d;

        for (int k = 0; k < 3; k++)
            mean[k] = (v[0][k] + v[1][k] + v[2][k]) / 3;
        dx_cloud_to_input(p, &s->cloud, mean);
        d = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) - 1;
        sum += d * d;
    }
    return sqrt(sum / m->n_faces);
}

static void noise_becomes_a_closed_mesh(void **state)
{
    static const enum dx_surface surfaces[] = {DX_SURFACE_RANDOM_SPHERE, DX_SURFACE_RANDOM_BUMPY,
                                               DX_SURFACE_RANDOM_TORUS};

    (void)state;
    for (size_t k = 0; k < 3; k++) {
        const struct dx_surface_config c = {surfaces[k], 20000, 0, 0.4, 4, 7};
        struct run r = {.max_points = 32, .tolerance = 0.1};
        struct halfedge_counts counts;
        struct dx_surface_points p;

        assert_int_equal(dx_surface_sample(&p, &c), 0);
        run_all(&r, p.xyz, p.n, NULL, false, true);
        counts = halfedge_count(&r.s.mesh.edges);
        assert_int_equal(counts.n_border, 0);
        assert_int_equal(counts.euler, dx_surface_euler(surfaces[k]));
        if (k == 0)
            assert_true(rms_of_sphere(&r.s) < 0.15 * p.spacing);
        dx_stages_fini(&r.s);
        free(p.xyz);
    }
}

/* Spheres in each other at six spacings, with points that are three apart: no triangle leads from
 * one to the other. */
static void sheets_stay_apart(void **state)
{
    const struct dx_surface_config c = {DX_SURFACE_NESTED, 20000, 0, 0.2, 6, 7};
    struct run r = {.max_points = 8, .tolerance = 0.1};
    struct halfedge_counts counts;
    struct dx_surface_points p;

    (void)state;
    assert_int_equal(dx_surface_sample(&p, &c), 0);
    run_all(&r, p.xyz, p.n, NULL, false, true);
    counts = halfedge_count(&r.s.mesh.edges);
    assert_int_equal(r.grown.n_components, 2);
    assert_int_equal(counts.n_border, 0);
    assert_int_equal(counts.euler, 4);
    dx_stages_fini(&r.s);
    free(p.xyz);
}

/* Edges off the points get vertices on them, until there are none. */
static void refining_comes_to_the_surface(void **state)
{
    const struct dx_surface_config c = {DX_SURFACE_SPHERE, 20000, 0.2, 0, 4, 7};
    struct run r = {.max_points = 64, .tolerance = 0.05};
    struct dx_surface_points p;

    (void)state;
    assert_int_equal(dx_surface_sample(&p, &c), 0);
    run_all(&r, p.xyz, p.n, NULL, true, true);
    assert_true(r.refined[0].n_split > 500);
    assert_true(r.refined[0].n_flips > 0);
    assert_true(r.refined[2].n_off < r.refined[0].n_off / 10);
    assert_true(rms_of_sphere(&r.s) < 0.1 * p.spacing);
    dx_stages_fini(&r.s);
    free(p.xyz);
}

static uint64_t hash_of(const struct dx_stages *s)
{
    const struct dx_halfedges *m = &s->mesh.edges;
    uint64_t h = dx_hash(0, s->mesh.at, m->n_vertices * sizeof(*s->mesh.at));

    return dx_hash(h, m->of, m->n * sizeof(*m->of));
}

static void threads_do_not_matter(void **state)
{
    static const unsigned counts[] = {1, 2, 3, 8};
    const struct dx_surface_config c = {DX_SURFACE_RANDOM_BUMPY, 10000, 0, 0.4, 4, 7};
    struct run r = {.max_points = 32, .tolerance = 0.1};
    struct dx_surface_points p;
    uint64_t first;

    (void)state;
    assert_int_equal(dx_surface_sample(&p, &c), 0);
    run_all(&r, p.xyz, p.n, NULL, false, true);
    first = hash_of(&r.s);
    dx_stages_fini(&r.s);
    for (size_t k = 0; k < 4; k++) {
        struct dx_pool *pool;

        assert_int_equal(dx_pool_new(&pool, counts[k]), 0);
        run_all(&r, p.xyz, p.n, pool, false, true);
        assert_true(hash_of(&r.s) == first);
        dx_stages_fini(&r.s);
        dx_pool_free(pool);
    }
    free(p.xyz);
}

static void normals_face_away(void **state)
{
    const struct dx_surface_config c = {DX_SURFACE_RANDOM_SPHERE, 6000, 0, 0.3, 4, 7};
    const struct dx_cloud_smooth_config smooth = {0};
    struct dx_cloud_smooth_scale scale;
    struct dx_cloud_smooth_stats stats;
    struct dx_cluster_config cluster;
    struct dx_surface_points p;
    struct dx_stages s;

    (void)state;
    dx_cluster_defaults(&cluster);
    assert_int_equal(dx_surface_sample(&p, &c), 0);
    p.xyz[3 * 9] = NAN; /* left out */
    for (int k = 0; k < 3; k++)
        p.xyz[3 * 12 + k] = p.xyz[3 * 11 + k];
    assert_int_equal(dx_stages_init(&s, p.xyz, p.n, NULL, NULL), 0);
    assert_int_equal(s.n, p.n - 2);
    assert_int_equal(dx_stages_smooth(&s, &scale, &stats, &smooth, NULL), 0);
    for (int k = 0; k < 2; k++) {
        const double(*xyz)[3] = (const double(*)[3])(k ? s.reduced.xyz : s.xyz);
        const float(*normal)[3];

        assert_int_equal(dx_stages_orient(&s, NULL, NULL), 0);
        normal = (const float(*)[3])(k ? s.reduced.normal : s.normal);
        for (uint32_t i = 0; i < (k ? s.reduced.n : s.n); i++)
            assert_true(xyz[i][0] * (double)normal[i][0] + xyz[i][1] * (double)normal[i][1] +
                            xyz[i][2] * (double)normal[i][2] >
                        0.7);
        if (k == 0) {
            assert_int_equal(dx_stages_cluster(&s, &cluster, NULL), 0);
            assert_int_equal(dx_stages_reduce(&s, NULL), 0);
        }
    }
    dx_stages_fini(&s);
    free(p.xyz);
}

static void any_cloud_is_taken(void **state)
{
    static double xyz[3 * 300];

    (void)state;
    for (uint64_t seed = 0; seed < 300; seed++) {
        struct dx_rng g = dx_rng_init(seed, 6);
        const uint32_t n = dx_rng_below(&g, 300), kind = dx_rng_below(&g, 5);
        struct run r = {.max_points = 1 + dx_rng_below(&g, 20), .tolerance = 0.2 * dx_rng_unit(&g)};

        for (uint32_t k = 0; k < 3 * n; k++) {
            xyz[k] = dx_rng_unit(&g);
            if (kind == 0 && k % 3 == 2)
                xyz[k] = 0.3; /* a plane */
            else if (kind == 1)
                xyz[k] = floor(6 * xyz[k]) / 6;
            else if (kind == 2 && k % 3)
                xyz[k] = xyz[k - 1]; /* a line */
            else if (kind == 3 && k % 3 == 2)
                xyz[k] = 0.2 * (xyz[k - 1] - 0.5) * (xyz[k - 2] - 0.5) + 0.01 * xyz[k];
        }
        run_all(&r, xyz, n, NULL, seed % 3 == 0, seed % 4 != 0);
        dx_stages_fini(&r.s);
    }
}

static void parameters_are_checked(void **state)
{
    struct dx_cloud_smooth_scale scale = {.spacing = 1, .sw = 1, .sr = 1};
    struct dx_surface_mesh mesh = {.cap = 0};
    struct dx_refine_config bad[3];
    struct dx_cloud c;

    (void)state;
    assert_int_equal(dx_cloud_init(&c, NULL, 0, NULL, NULL), 0);
    for (size_t k = 0; k < 3; k++)
        dx_refine_defaults(&bad[k]);
    bad[0].tolerance = -1;
    bad[1].min_ratio = 1.5;
    bad[2].max_turn_deg = 90;
    for (size_t k = 0; k < 3; k++) {
        struct dx_err err = {""};
        struct dx_refine_stats stats;

        assert_int_equal(dx_refine(&mesh, &stats, &c, &scale, &bad[k], NULL, &err), -EINVAL);
        assert_non_null(strstr(err.text, "expected"));
    }
    dx_cloud_fini(&c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(noise_becomes_a_closed_mesh),
        cmocka_unit_test(refining_comes_to_the_surface),
        cmocka_unit_test(sheets_stay_apart),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(normals_face_away),
        cmocka_unit_test(any_cloud_is_taken),
        cmocka_unit_test(parameters_are_checked),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
