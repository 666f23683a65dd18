/* Repaired meshes: known damages are counted and gone; what is whole stays as it is; of random
 * triangles the outcome is a manifold whose triangles agree, whatever they were. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "core/base/rng.h"
#include "tools/mesh_repair.h"
#include "tools/mesh_stats.h"
#include "tools/mesh_topology.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void make(struct dx_mesh *mesh, const float (*xyz)[3], uint32_t n_vertices,
                 const uint32_t *index, uint32_t n_triangles)
{
    assert_int_equal(dx_mesh_init(mesh, n_vertices, n_triangles, 0, 0), 0);
    memcpy(mesh->xyz, xyz, n_vertices * sizeof(*xyz));
    if (n_triangles)
        memcpy(mesh->index, index, n_triangles * 3 * sizeof(*index));
}

struct counted {
    struct dx_mesh_repair repair;
    struct dx_mesh_stats stats;
    struct dx_mesh_topology topology;
};

/* Repairs, and expects what is always so. */
static struct counted repaired(struct dx_mesh *mesh, uint32_t max_hole)
{
    struct counted c;

    assert_int_equal(dx_mesh_repair(mesh, max_hole, &c.repair), 0);
    assert_int_equal(dx_mesh_stats_compute(&c.stats, mesh), 0);
    assert_int_equal(dx_mesh_topology_compute(&c.topology, mesh), 0);
    assert_int_equal(c.stats.nonmanifold_edges, 0);
    assert_int_equal(c.stats.duplicate_directed_edges, 0);
    assert_int_equal(c.topology.nonmanifold_vertices, 0);
    assert_int_equal(c.stats.points, mesh->n_vertices);
    return c;
}

static const float corners[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                    {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
static const uint32_t box[12][3] = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7},
                                    {0, 1, 5}, {0, 5, 4}, {1, 2, 6}, {1, 6, 5},
                                    {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};

static void test_a_whole_mesh_stays(void **state)
{
    const struct dx_mesh_repair none = {0};
    struct dx_mesh mesh;
    struct counted c;

    (void)state;
    make(&mesh, corners, 8, box[0], 12);
    c = repaired(&mesh, 16);
    assert_memory_equal(&c.repair, &none, sizeof(none));
    assert_memory_equal(mesh.index, box, sizeof(box));
    assert_memory_equal(mesh.xyz, corners, sizeof(corners));
    dx_mesh_fini(&mesh);
    make(&mesh, corners, 8, NULL, 0);
    c = repaired(&mesh, 16);
    assert_memory_equal(&c.repair, &none, sizeof(none));
    assert_int_equal(mesh.n_vertices, 0);
    dx_mesh_fini(&mesh);
}

/* Every triangle of the box twice, one turned, one with equal corners, the lid left out. */
static void test_faces_are_mended(void **state)
{
    uint32_t index[24][3];
    struct dx_mesh mesh;
    struct counted c;

    (void)state;
    memcpy(index, box, sizeof(box));
    memcpy(index + 12, box, sizeof(box));
    index[5][0] = 4, index[5][1] = 5, index[5][2] = 0;
    memcpy(index[15], (uint32_t[3]){1, 1, 2}, sizeof(index[15]));
    make(&mesh, corners, 8, index[0], 24);
    c = repaired(&mesh, 0);
    assert_int_equal(c.repair.degenerate, 1);
    assert_int_equal(c.repair.duplicate, 11);
    assert_int_equal(c.repair.turned, 1);
    assert_int_equal(mesh.n_triangles, 12);
    assert_int_equal(c.stats.boundary_edges, 0);
    dx_mesh_fini(&mesh);

    memmove(index + 2, index + 4, sizeof(index[0]) * 8); /* without the lid, a rim of 4 edges */
    make(&mesh, corners, 8, index[0], 10);
    c = repaired(&mesh, 3);
    assert_int_equal(c.repair.holes, 0);
    assert_int_equal(c.stats.boundary_edges, 4);
    c = repaired(&mesh, 4);
    assert_int_equal(c.repair.holes, 1);
    assert_int_equal(c.repair.hole_triangles, 2);
    assert_int_equal(c.stats.boundary_edges, 0);
    assert_int_equal(c.stats.euler, 2);
    dx_mesh_fini(&mesh);
}

/* A rim is no hole: its cover would be as large as the surface. */
static void test_a_patch_stays_open(void **state)
{
    const uint32_t patch[2][3] = {{0, 1, 2}, {0, 2, 3}};
    struct dx_mesh mesh;
    struct counted c;

    (void)state;
    make(&mesh, corners, 4, patch[0], 2);
    c = repaired(&mesh, 16);
    assert_int_equal(c.repair.holes, 0);
    assert_int_equal(c.stats.boundary_edges, 4);
    dx_mesh_fini(&mesh);
}

/* A fin on the edge of two triangles in one plane: those two stay together. */
static void test_a_fin_is_told_apart(void **state)
{
    const float xyz[5][3] = {{0, 0, 0}, {1, 0, 0}, {0.5f, 1, 0}, {0.5f, -1, 0}, {0.5f, 0.1f, 1}};
    const uint32_t fin[3][3] = {{0, 1, 4}, {0, 1, 2}, {1, 0, 3}};
    struct dx_mesh mesh;
    struct counted c;

    (void)state;
    make(&mesh, xyz, 5, fin[0], 3);
    c = repaired(&mesh, 16);
    assert_int_equal(c.repair.nonmanifold, 1);
    assert_int_equal(c.repair.split, 2);
    assert_int_equal(c.repair.removed, 0);
    assert_int_equal(mesh.n_triangles, 3);
    assert_int_equal(c.stats.components, 2);
    assert_int_equal(c.stats.boundary_edges, 3 + 4);
    dx_mesh_fini(&mesh);
}

/* Two boxes that touch along an edge, and two that touch in a corner, become two. */
static void test_boxes_that_touch(void **state)
{
    static const uint32_t shared[2] = {2, 1}; /* corners of the second box that the first has */

    (void)state;
    for (uint32_t k = 0; k < 2; k++) {
        float xyz[16][3];
        uint32_t index[24][3];
        struct dx_mesh mesh;
        struct counted c;

        memcpy(xyz, corners, sizeof(corners));
        memcpy(index, box, sizeof(box));
        for (uint32_t v = 0; v < 8; v++) {
            xyz[8 + v][0] = corners[v][0] + 1;
            xyz[8 + v][1] = corners[v][1] + 1;
            xyz[8 + v][2] = corners[v][2] + (float)k;
        }
        for (uint32_t t = 0; t < 12; t++)
            for (int i = 0; i < 3; i++) {
                const uint32_t v = box[t][i];

                index[12 + t][i] = v == 0 ? (k ? 6 : 2) : v == 4 && k == 0 ? 6 : 8 + v;
            }
        make(&mesh, xyz, 16, index[0], 24);
        c = repaired(&mesh, 16);
        assert_int_equal(c.repair.split, shared[k]);
        assert_int_equal(c.repair.nonmanifold, k == 0);
        assert_int_equal(c.stats.components, 2);
        assert_int_equal(c.stats.boundary_edges, 0);
        assert_int_equal(c.stats.triangles, 24);
        dx_mesh_fini(&mesh);
    }
}

/* A band of one side is cut across. */
static void test_a_moebius_band_is_cut(void **state)
{
    float xyz[10][3];
    uint32_t index[10][3];
    struct dx_mesh mesh;
    struct counted c;

    (void)state;
    for (uint32_t k = 0; k < 5; k++) {
        const float a = 6.2831853f * (float)k / 5, b = a / 2;
        uint32_t u, v, w;

        for (int side = 0; side < 2; side++) {
            const float r = side ? 0.4f : -0.4f;

            xyz[2 * k + (uint32_t)side][0] = (1 + r * cosf(b)) * cosf(a);
            xyz[2 * k + (uint32_t)side][1] = (1 + r * cosf(b)) * sinf(a);
            xyz[2 * k + (uint32_t)side][2] = r * sinf(b);
        }
        u = 2 * k;
        v = k == 4 ? 1 : u + 2;
        w = k == 4 ? 0 : u + 3;
        memcpy(index[2 * k], (uint32_t[3]){u, v, u + 1}, sizeof(index[0]));
        memcpy(index[2 * k + 1], (uint32_t[3]){u + 1, v, w}, sizeof(index[0]));
    }
    make(&mesh, xyz, 10, index[0], 10);
    c = repaired(&mesh, 0);
    assert_int_equal(c.repair.cut, 1);
    assert_int_equal(c.repair.split, 2);
    assert_int_equal(mesh.n_triangles, 10);
    dx_mesh_fini(&mesh);
}

/* Triangles at random among few vertices: all damages at once, many times. */
static void test_whatever_it_was(void **state)
{
    struct dx_rng rng = dx_rng_init(7, 0);
    struct dx_mesh_repair seen = {0};

    (void)state;
    for (uint32_t round = 0; round < 3000; round++) {
        const uint32_t n_vertices = 4 + round % 9, n = round % 41;
        struct dx_mesh mesh, again;
        float xyz[12][3];
        uint32_t index[41][3];
        struct dx_mesh_repair none, did;

        for (uint32_t v = 0; v < n_vertices; v++)
            for (int k = 0; k < 3; k++)
                xyz[v][k] = (float)dx_rng_below(&rng, 8);
        for (uint32_t k = 0; k < 3 * n; k++)
            index[k / 3][k % 3] = dx_rng_below(&rng, n_vertices);
        make(&mesh, xyz, n_vertices, index[0], n);
        make(&again, xyz, n_vertices, index[0], n);
        did = repaired(&mesh, round % 17).repair;
        seen.cut += did.cut;
        seen.removed += did.removed;
        seen.holes += did.holes;
        (void)repaired(&again, round % 17);
        assert_int_equal(dx_mesh_digest(&mesh), dx_mesh_digest(&again));
        /* What was mended needs no more of it. */
        assert_int_equal(dx_mesh_repair(&again, 0, &none), 0);
        assert_int_equal(dx_mesh_digest(&mesh), dx_mesh_digest(&again));
        dx_mesh_fini(&mesh);
        dx_mesh_fini(&again);
    }
    assert_true(seen.cut > 0 && seen.removed > 0 && seen.holes > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_whole_mesh_stays), cmocka_unit_test(test_faces_are_mended),
        cmocka_unit_test(test_a_patch_stays_open), cmocka_unit_test(test_a_fin_is_told_apart),
        cmocka_unit_test(test_boxes_that_touch),   cmocka_unit_test(test_a_moebius_band_is_cut),
        cmocka_unit_test(test_whatever_it_was),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
