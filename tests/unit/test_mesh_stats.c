/* Statistics of meshes whose numbers are known. */
#include "tools/mesh_stats.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

/* rows x cols cells, two triangles each; with wrap both ways it is a torus. */
static struct dx_mesh grid(uint32_t rows, uint32_t cols, int torus)
{
    uint32_t height = rows + !torus, width = cols + !torus;
    struct dx_mesh m;
    uint32_t *t;

    assert_int_equal(dx_mesh_init(&m, height * width, 2 * rows * cols, 0, 0), 0);
    t = m.index;
    for (uint32_t v = 0; v < height * width; v++) {
        const uint32_t row = v / width, col = v % width;

        memcpy(m.xyz + 3 * v, (float[]){(float)col, (float)row, 0}, 12);
    }
    for (uint32_t i = 0; i < rows; i++)
        for (uint32_t j = 0; j < cols; j++, t += 6) {
            uint32_t a = i * width + j, b = i * width + (j + 1) % width;
            uint32_t d = (i + 1) % height * width + j;
            uint32_t c = (i + 1) % height * width + (j + 1) % width;

            memcpy(t, (uint32_t[]){a, b, c, a, c, d}, 24);
        }
    return m;
}

static struct dx_mesh triangles(uint32_t n_vertices, uint32_t n, const uint32_t *index)
{
    struct dx_mesh m;

    assert_int_equal(dx_mesh_init(&m, n_vertices, n, 0, 0), 0);
    memset(m.xyz, 0, n_vertices * 12);
    for (uint32_t k = 0; k < 3 * n; k++)
        m.index[k] = index[k];
    return m;
}

static struct dx_mesh_stats stats_of(struct dx_mesh m)
{
    struct dx_mesh_stats s;

    assert_int_equal(dx_mesh_stats_compute(&s, &m), 0);
    dx_mesh_fini(&m);
    return s;
}

static void test_patch(void **state)
{
    struct dx_mesh_stats s = stats_of(grid(5, 7, 0));

    (void)state;
    assert_int_equal(s.points, 48);
    assert_int_equal(s.triangles, 70);
    assert_int_equal(s.boundary_edges, 24);
    assert_int_equal(s.edges, (3 * 70 + 24) / 2);
    assert_int_equal(s.components, 1);
    assert_int_equal(s.nonmanifold_edges, 0);
    assert_int_equal(s.duplicate_directed_edges, 0);
    assert_int_equal(s.euler, 1);
}

static void test_torus(void **state)
{
    struct dx_mesh_stats s = stats_of(grid(9, 8, 1));

    (void)state;
    assert_int_equal(s.points, 72);
    assert_int_equal(s.boundary_edges, 0);
    assert_int_equal(s.euler, 0);
    assert_int_equal(s.components, 1);
}

static void test_fan_of_three_on_one_edge(void **state)
{
    static const uint32_t index[] = {0, 1, 2, 1, 0, 3, 0, 1, 4};
    struct dx_mesh_stats s = stats_of(triangles(5, 3, index));

    (void)state;
    assert_int_equal(s.nonmanifold_edges, 1);
    assert_int_equal(s.duplicate_directed_edges, 1);
    assert_int_equal(s.boundary_edges, 6);
    assert_int_equal(s.edges, 7);
}

static void test_flipped_neighbour(void **state)
{
    static const uint32_t index[] = {0, 1, 2, 0, 1, 3};
    struct dx_mesh_stats s = stats_of(triangles(4, 2, index));

    (void)state;
    assert_int_equal(s.duplicate_directed_edges, 1);
    assert_int_equal(s.nonmanifold_edges, 0);
    assert_int_equal(s.boundary_edges, 4);
}

static void test_components_and_unused_points(void **state)
{
    static const uint32_t index[] = {0, 1, 2, 2, 3,
                                     4, 6, 7, 8}; /* two meet in a vertex; 5 is free */
    struct dx_mesh_stats s = stats_of(triangles(9, 3, index));

    (void)state;
    assert_int_equal(s.components, 2);
    assert_int_equal(s.points, 8);
    assert_int_equal(s.boundary_edges, 9);
}

static void test_empty(void **state)
{
    struct dx_mesh_stats s = stats_of(triangles(0, 0, NULL));

    (void)state;
    assert_int_equal(s.points, 0);
    assert_int_equal(s.edges, 0);
    assert_int_equal(s.components, 0);
    assert_int_equal(s.euler, 0);
}

/* A hub of many spokes, last bucket and qsort; the spokes come in no order. */
static void test_large_fan(void **state)
{
    enum { N = 1000 };
    uint32_t index[3 * N];
    struct dx_mesh_stats s;

    (void)state;
    for (uint32_t k = 0; k < N; k++) {
        uint32_t t = k * 7 % N; /* 7 and 1000 have no common factor */

        memcpy(index + 3 * k, (uint32_t[]){0, 1 + t, 1 + (t + 1) % N}, 12);
    }
    s = stats_of(triangles(N + 1, N, index));
    assert_int_equal(s.boundary_edges, N);
    assert_int_equal(s.edges, 2 * N);
    assert_int_equal(s.euler, 1);
    assert_int_equal(s.nonmanifold_edges, 0);
}

static void test_digest(void **state)
{
    struct dx_mesh m = grid(3, 3, 0);
    uint64_t before = dx_mesh_digest(&m);

    (void)state;
    assert_int_equal(dx_mesh_digest(&m), before);
    m.xyz[4] = -0.0f; /* a bit is enough */
    assert_int_not_equal(dx_mesh_digest(&m), before);
    m.xyz[4] = 0;
    assert_int_equal(dx_mesh_digest(&m), before);
    m.index[3] = 1;
    assert_int_not_equal(dx_mesh_digest(&m), before);
    dx_mesh_fini(&m);
    /* The value itself is part of golden tests: it may not change. */
    m = grid(1, 1, 0);
    assert_int_equal(dx_mesh_digest(&m), 0x198d5efb71f29a33u);
    dx_mesh_fini(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_patch),
        cmocka_unit_test(test_torus),
        cmocka_unit_test(test_fan_of_three_on_one_edge),
        cmocka_unit_test(test_flipped_neighbour),
        cmocka_unit_test(test_components_and_unused_points),
        cmocka_unit_test(test_empty),
        cmocka_unit_test(test_large_fan),
        cmocka_unit_test(test_digest),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
