/* What a mesh is: fans and loops of meshes that are known, where it goes through itself, distances
 * against the plain search. */
#include "core/base/rng.h"
#include "tools/mesh_crossings.h"
#include "tools/mesh_distance.h"
#include "tools/mesh_topology.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

static void expect(const uint32_t *index, uint32_t n_triangles, uint32_t n_bow_ties,
                   uint32_t n_loops, uint32_t longest)
{
    struct dx_mesh_topology t;
    struct dx_mesh mesh;

    assert_int_equal(dx_mesh_init(&mesh, 16, n_triangles, 0, 0), 0);
    if (n_triangles)
        memcpy(mesh.index, index, n_triangles * 3 * sizeof(*index));
    assert_int_equal(dx_mesh_topology_compute(&t, &mesh), 0);
    assert_int_equal(t.nonmanifold_vertices, n_bow_ties);
    assert_int_equal(t.boundary_loops, n_loops);
    assert_int_equal(t.longest_loop, longest);
    dx_mesh_fini(&mesh);
}

#define TETRAHEDRON 0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2

static void knows_fans_and_loops(void **state)
{
    (void)state;
    expect(NULL, 0, 0, 0, 0);
    expect((uint32_t[]){0, 1, 2}, 1, 0, 1, 3);
    expect((uint32_t[]){TETRAHEDRON}, 4, 0, 0, 0);
    expect((uint32_t[]){TETRAHEDRON}, 3, 0, 1, 3);
    /* Two triangles apart, and with a common corner: the loops stay two. */
    expect((uint32_t[]){0, 1, 2, 3, 4, 5}, 2, 0, 2, 3);
    expect((uint32_t[]){0, 1, 2, 0, 4, 5}, 2, 1, 2, 3);
    /* Two tetrahedra on one vertex; two squares turned against each other have one rim of 4. */
    expect((uint32_t[]){TETRAHEDRON, 0, 5, 6, 0, 7, 5, 0, 6, 7, 5, 7, 6}, 8, 1, 0, 0);
    expect((uint32_t[]){0, 1, 2, 2, 3, 0}, 2, 0, 1, 4);
    expect((uint32_t[]){0, 1, 2, 0, 2, 3}, 2, 0, 1, 4);
    expect((uint32_t[]){0, 1, 2, 3, 2, 0}, 2, 0, 1, 4);
    /* Three triangles at one edge are one fan at its ends: the edge is what is wrong. */
    expect((uint32_t[]){0, 1, 2, 1, 0, 3, 0, 1, 4}, 3, 0, 1, 6);
}

/* A ring of six triangles: a rim outside, one inside. */
static void knows_two_rims(void **state)
{
    uint32_t index[6 * 3];

    (void)state;
    for (uint32_t k = 0; k < 3; k++)
        memcpy(index + 6 * k,
               (uint32_t[]){k, (k + 1) % 3, 3 + k, 3 + k, (k + 1) % 3, 3 + (k + 1) % 3},
               6 * sizeof(*index));
    expect(index, 6, 0, 2, 3);
}

static void distance_of_a_triangle(void **state)
{
    static const double a[] = {0, 0, 0}, b[] = {4, 0, 0}, c[] = {0, 3, 0};
    static const struct {
        double p[3], want2;
    } cases[] = {
        {{1, 1, 0}, 0},  {{1, 1, 2}, 4},
        {{1, 1, -2}, 4}, {{-1, -1, 0}, 2},
        {{2, -3, 0}, 9}, {{7, 0, 4}, 25},
        {{0, 5, -1}, 5}, {{4, 0, 0}, 0},
        {{-2, 1, 1}, 5}, {{2 + 3, 1.5 + 4, 0}, 25},
    };

    (void)state;
    for (size_t k = 0; k < sizeof(cases) / sizeof(cases[0]); k++)
        for (int turn = 0; turn < 2; turn++) {
            const double d2 = turn ? dx_triangle_distance2(cases[k].p, c, b, a)
                                   : dx_triangle_distance2(cases[k].p, a, b, c);

            if (fabs(d2 - cases[k].want2) > 1e-12)
                fail_msg("case %zu: %g, expected %g", k, d2, cases[k].want2);
        }
    /* No area: the longest side; no length: the point. */
    assert_true(dx_triangle_distance2((double[]){2, 1, 0}, a, b, (double[]){1, 0, 0}) == 1);
    assert_true(dx_triangle_distance2((double[]){2, 1, 0}, a, a, a) == 5);
}

/* Triangles of all sizes, some equal, some without area; points inside and far away. */
static void tree_finds_the_nearest(void **state)
{
    enum { N_VERTICES = 200, MOST = 400 };
    struct dx_rng rng = dx_rng_init(7, 0);
    static double xyz[3 * N_VERTICES];
    static uint32_t index[3 * MOST];

    (void)state;
    for (size_t k = 0; k < 3 * N_VERTICES; k++)
        xyz[k] = floor(8 * dx_rng_unit(&rng)) / 8;
    for (size_t k = 0; k < 3 * MOST; k++)
        index[k] = (uint32_t)(N_VERTICES * dx_rng_unit(&rng));
    for (size_t n = 1; n <= MOST; n += n < 12 ? 1 : 97) {
        struct dx_triangle_tree d;

        assert_int_equal(dx_triangle_tree_init(&d, xyz, index, n), 0);
        for (int i = 0; i < 200; i++) {
            const double scale = i % 4 ? 1.2 : 1000;
            double p[3], want = INFINITY;

            for (int k = 0; k < 3; k++)
                p[k] = scale * dx_rng_unit(&rng);
            for (size_t t = 0; t < n; t++)
                want = fmin(want, dx_triangle_distance2(p, xyz + 3 * index[3 * t],
                                                        xyz + 3 * index[3 * t + 1],
                                                        xyz + 3 * index[3 * t + 2]));
            assert_true(dx_mesh_distance_to(&d, p) == sqrt(want));
        }
        dx_triangle_tree_fini(&d);
    }
}

static void expect_crossings(const double *xyz, const uint32_t *index, size_t n, uint64_t n_pairs,
                             uint32_t n_triangles)
{
    struct dx_mesh_crossings c;

    assert_int_equal(dx_mesh_crossings_count(&c, xyz, index, n), 0);
    assert_int_equal(c.n_pairs, n_pairs);
    assert_int_equal(c.n_triangles, n_triangles);
}

static void knows_crossings(void **state)
{
    /* A triangle, and points around it: above and below its inside, beside it, on its corner. */
    static const double xyz[] = {0, 0, 0, 4, 0, 0, 0, 4, 0, 1, 1, 1, 1, 1, -1, 9, 9, 1, 1, 1, 0};

    (void)state;
    expect_crossings(NULL, NULL, 0, 0, 0);
    expect_crossings(xyz, (uint32_t[]){0, 1, 2}, 1, 0, 0);
    expect_crossings(xyz, (uint32_t[]){0, 1, 2, 3, 4, 5}, 2, 1, 2);
    expect_crossings(xyz, (uint32_t[]){5, 4, 3, 2, 1, 0}, 2, 1, 2);
    /* By the side opposite of a corner that both have; not by an edge that both have. */
    expect_crossings(xyz, (uint32_t[]){0, 1, 2, 0, 3, 4}, 2, 1, 2);
    expect_crossings(xyz, (uint32_t[]){0, 1, 2, 0, 1, 3}, 2, 0, 0);
    /* A corner that rests on it does not go through it; nor what passes beside. */
    expect_crossings(xyz, (uint32_t[]){0, 1, 2, 3, 6, 5}, 2, 0, 0);
    expect_crossings(xyz, (uint32_t[]){1, 2, 5, 3, 4, 0}, 2, 0, 0);
    /* Both ends of one long edge go through two, which do not meet each other. */
    expect_crossings(xyz, (uint32_t[]){0, 1, 2, 3, 4, 5, 0, 1, 2}, 3, 2, 3);
}

/* The tree misses no pair: of triangles of all sizes, against one tree for each pair. */
static void tree_finds_all_crossings(void **state)
{
    enum { N_VERTICES = 60, N = 80 };
    struct dx_rng rng = dx_rng_init(8, 0);
    static double xyz[3 * N_VERTICES];
    static uint32_t index[3 * N];
    uint64_t n_pairs = 0;
    struct dx_mesh_crossings c;

    (void)state;
    for (size_t k = 0; k < 3 * N_VERTICES; k++)
        xyz[k] = dx_rng_unit(&rng);
    for (uint32_t k = 0; k < N; k++)
        for (uint32_t i = 0; i < 3; i++) /* a third of the points each: three that differ */
            index[3 * k + i] = 20 * i + (uint32_t)(20 * dx_rng_unit(&rng));
    for (size_t a = 0; a < N; a++)
        for (size_t b = a + 1; b < N; b++) {
            uint32_t two[6];

            memcpy(two, index + 3 * a, sizeof(two) / 2);
            memcpy(two + 3, index + 3 * b, sizeof(two) / 2);
            assert_int_equal(dx_mesh_crossings_count(&c, xyz, two, 2), 0);
            n_pairs += c.n_pairs;
        }
    assert_true(n_pairs > N);
    assert_int_equal(dx_mesh_crossings_count(&c, xyz, index, N), 0);
    assert_int_equal(c.n_pairs, n_pairs);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(knows_fans_and_loops),   cmocka_unit_test(knows_two_rims),
        cmocka_unit_test(distance_of_a_triangle), cmocka_unit_test(tree_finds_the_nearest),
        cmocka_unit_test(knows_crossings),        cmocka_unit_test(tree_finds_all_crossings),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
