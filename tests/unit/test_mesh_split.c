/* Bow-ties: fans that meet in one vertex get a vertex each; meshes without are left alone. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "core/base/rng.h"
#include "tools/mesh_split.h"
#include "tools/mesh_stats.h"

#include <stdlib.h>
#include <string.h>

static void make(struct dx_mesh *mesh, uint32_t n_vertices, const uint32_t (*triangle)[3],
                 uint32_t n)
{
    assert_int_equal(dx_mesh_init(mesh, n_vertices, n, 2, 1), 0);
    for (uint32_t v = 0; v < n_vertices; v++) {
        mesh->xyz[3 * v] = (float)v;
        mesh->xyz[3 * v + 1] = mesh->xyz[3 * v + 2] = 1;
        mesh->id[v] = 10 * v;
        mesh->attr[v] = (uint16_t)(7 * v);
    }
    memcpy(mesh->index, triangle, n * sizeof(*triangle));
}

static void test_bow_tie(void **state)
{
    static const uint32_t triangles[][3] = {{0, 1, 2}, {2, 3, 4}, {2, 4, 5}};
    struct dx_mesh mesh;

    (void)state;
    make(&mesh, 6, triangles, 3);
    assert_int_equal(dx_mesh_split(&mesh), 1);
    assert_int_equal(mesh.n_vertices, 7);
    assert_int_equal(mesh.index[2], 2); /* the first fan keeps the vertex */
    assert_int_equal(mesh.index[3], 6);
    assert_int_equal(mesh.index[6], 6);
    assert_int_equal(mesh.index[4], 3);
    assert_true(mesh.xyz[18] == 2 && mesh.xyz[19] == 1);
    assert_int_equal(mesh.id[6], 20);
    assert_int_equal(mesh.attr[6], 14);
    dx_mesh_fini(&mesh);
}

static void test_manifold_is_left_alone(void **state)
{
    static const uint32_t triangles[][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}};
    struct dx_mesh mesh;
    uint32_t index[12];

    (void)state;
    make(&mesh, 5, triangles, 4);
    memcpy(index, mesh.index, sizeof(index));
    assert_int_equal(dx_mesh_split(&mesh), 0);
    assert_memory_equal(mesh.index, index, sizeof(index));
    dx_mesh_fini(&mesh);
    make(&mesh, 0, triangles, 0);
    assert_int_equal(dx_mesh_split(&mesh), 0);
    assert_int_equal(mesh.n_vertices, 0);
    dx_mesh_fini(&mesh);
}

/* Corners of v that one can reach over shared edges are all of them: what split promises. */
static uint32_t n_fans(const struct dx_mesh *mesh, uint32_t v)
{
    uint32_t seen[64], n = 0, n_reached = 1, fans;

    for (uint32_t c = 0; c < 3 * mesh->n_triangles; c++)
        if (mesh->index[c] == v && n < 64)
            seen[n++] = c / 3;
    fans = n ? 1 : 0;
    for (uint32_t k = 0; k < n; k++) { /* seen[0..n_reached) hang together */
        if (k == n_reached) {
            fans++;
            n_reached++;
        }
        for (uint32_t m = n_reached; m < n; m++) {
            int shared = 0;

            for (int i = 0; i < 9; i++)
                shared += mesh->index[3 * seen[k] + (uint32_t)i / 3] ==
                          mesh->index[3 * seen[m] + (uint32_t)i % 3];
            if (shared == 2) {
                uint32_t t = seen[m];

                seen[m] = seen[n_reached];
                seen[n_reached++] = t;
                m = n_reached - 1;
            }
        }
    }
    return fans;
}

/* Random triangles of a grid of 9 x 9 vertices: one fan at each vertex after, the same faces. */
static void test_random_grids(void **state)
{
    struct dx_rng rng = dx_rng_init(3, 0);

    (void)state;
    for (int round = 0; round < 200; round++) {
        uint32_t triangles[128][3], n = 0;
        struct dx_mesh_stats before, after;
        struct dx_mesh mesh;

        for (uint32_t cell = 0; cell < 64; cell++) {
            uint32_t a = cell / 8 * 9 + cell % 8;

            if (dx_rng_below(&rng, 2))
                memcpy(triangles[n++], (uint32_t[3]){a, a + 1, a + 10}, sizeof(triangles[0]));
            if (dx_rng_below(&rng, 2))
                memcpy(triangles[n++], (uint32_t[3]){a, a + 10, a + 9}, sizeof(triangles[0]));
        }
        make(&mesh, 81, triangles, n);
        assert_int_equal(dx_mesh_stats_compute(&before, &mesh), 0);
        assert_true(dx_mesh_split(&mesh) >= 0);
        assert_int_equal(dx_mesh_stats_compute(&after, &mesh), 0);
        assert_int_equal(after.edges, before.edges);
        assert_int_equal(after.boundary_edges, before.boundary_edges);
        for (uint32_t v = 0; v < mesh.n_vertices; v++)
            assert_true(n_fans(&mesh, v) <= 1);
        for (uint32_t c = 0; c < 3 * n; c++)
            assert_int_equal(mesh.id[mesh.index[c]], 10 * triangles[c / 3][c % 3]);
        dx_mesh_fini(&mesh);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bow_tie),
        cmocka_unit_test(test_manifold_is_left_alone),
        cmocka_unit_test(test_random_grids),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
