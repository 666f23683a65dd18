/* A cloud's mesh: the vertices that triangles use, or all that a mode gave; digits far away. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "tools/cloud_mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double points[5][3] = {{0, 0, 0}, {NAN, 1, 1}, {1, 0, 0}, {7, 7, 7}, {0, 1, 0}};

static void add(struct dx_cloud_mesh *m, uint32_t a, uint32_t b, uint32_t c)
{
    assert_int_equal(dx_cloud_mesh_triangle(m, (const uint32_t[3]){a, b, c}), 0);
}

static void test_used_points_become_vertices(void **state)
{
    struct dx_out_options write = {0};
    struct dx_cloud_mesh m = {0};
    struct dx_mesh mesh;

    (void)state;
    add(&m, 4, 0, 2);
    assert_int_equal(dx_cloud_mesh_make(&mesh, &m, points[0], 5, &write), 0);
    assert_int_equal(mesh.n_vertices, 3);
    assert_int_equal(mesh.n_triangles, 1);
    assert_memory_equal(mesh.index, ((const uint32_t[]){2, 0, 1}), 12);
    assert_true(mesh.xyz[3] == 1 && mesh.xyz[7] == 1);
    assert_false(write.world);
    dx_mesh_fini(&mesh);
    dx_cloud_mesh_fini(&m);
}

static void test_a_modes_own_points_all_stay(void **state)
{
    const float normals[4][3] = {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {0, 0, -1}};
    struct dx_out_options write = {0};
    struct dx_cloud_mesh m = {0};
    struct dx_mesh mesh;
    double *xyz = calloc(12, sizeof(*xyz));
    float *normal = malloc(sizeof(normals));

    (void)state;
    assert_non_null(xyz);
    assert_non_null(normal);
    memcpy(normal, normals, sizeof(normals));
    for (size_t k = 0; k < 4; k++)
        xyz[3 * k] = (double)k;
    dx_cloud_mesh_points(&m, xyz, normal, 4);
    add(&m, 0, 1, 3);
    assert_int_equal(dx_cloud_mesh_make(&mesh, &m, points[0], 5, &write), 0);
    assert_int_equal(mesh.n_vertices, 4);
    assert_true(mesh.xyz[9] == 3);
    assert_memory_equal(mesh.normal, normals, sizeof(normals));
    dx_mesh_fini(&mesh);
    dx_cloud_mesh_fini(&m);
}

static void test_far_away_keeps_its_digits(void **state)
{
    const double far[3][3] = {{5e8 + 0.25, 0, 0}, {5e8 + 1.5, 0, 0}, {5e8, 1, 0}};
    struct dx_out_options write = {0};
    struct dx_cloud_mesh m = {0};
    struct dx_mesh mesh;
    double p[3];

    (void)state;
    add(&m, 0, 1, 2);
    assert_int_equal(dx_cloud_mesh_make(&mesh, &m, far[0], 3, &write), 0);
    assert_true(write.world);
    for (size_t v = 0; v < 3; v++) {
        dx_out_vertex(p, &mesh, v, &write);
        assert_memory_equal(p, far[v], sizeof(p));
    }
    dx_mesh_fini(&mesh);
    dx_cloud_mesh_fini(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_used_points_become_vertices),
        cmocka_unit_test(test_a_modes_own_points_all_stay),
        cmocka_unit_test(test_far_away_keeps_its_digits),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
