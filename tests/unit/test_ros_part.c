/* Parts of a mesh: together they are the mesh, each within its room. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "tools/ros_part.h"

#include <stdbool.h>
#include <string.h>

enum { ROWS = 9, COLS = 7, N_VERTICES = ROWS * COLS, N_TRIANGLES = 2 * (ROWS - 1) * (COLS - 1) };

/* A grid whose vertices tell who they are. */
static void make_grid(struct dx_mesh *mesh)
{
    uint32_t *at;

    assert_int_equal(dx_mesh_init(mesh, N_VERTICES, N_TRIANGLES, 0, 0), 0);
    for (uint32_t k = 0; k < N_VERTICES; k++)
        for (uint32_t i = 0; i < 3; i++)
            mesh->xyz[3 * k + i] = (float)(10 * k + i);
    at = mesh->index;
    for (uint32_t row = 0; row + 1 < ROWS; row++)
        for (uint32_t col = 0; col + 1 < COLS; col++) {
            uint32_t v = row * COLS + col;
            const uint32_t cell[6] = {v, v + 1, v + COLS, v + 1, v + COLS + 1, v + COLS};

            memcpy(at, cell, sizeof(cell));
            at += 6;
        }
}

static void check_part(const struct dx_ros_part *p, const struct dx_mesh *mesh, uint32_t first,
                       uint32_t next, uint32_t max)
{
    bool used[N_VERTICES] = {false};
    uint32_t n_used = 0;

    assert_true(next > first && next <= N_TRIANGLES);
    assert_true(p->n_vertices <= max && p->n_indices == 3 * (next - first));
    for (uint32_t k = 0; k < p->n_indices; k++) {
        uint32_t v = mesh->index[3 * first + k];

        assert_true(p->index[k] < p->n_vertices);
        assert_memory_equal(p->xyz + 3 * p->index[k], mesh->xyz + 3 * v, 3 * sizeof(float));
        n_used += !used[v];
        used[v] = true;
    }
    assert_int_equal(p->n_vertices, n_used); /* each once, and none besides */
}

/* With room for a triangle, for some, for all; twice, since the memory is used again. */
static void parts_are_the_mesh(void **state)
{
    struct dx_mesh mesh;

    (void)state;
    make_grid(&mesh);
    for (uint32_t max = 3; max <= N_VERTICES + 1; max++) {
        struct dx_ros_part *p;
        uint32_t n_parts[2] = {0};

        assert_int_equal(dx_ros_part_new(&p, max), 0);
        for (int pass = 0; pass < 2; pass++) {
            uint32_t first = 0, next;

            assert_int_equal(dx_ros_part_begin(p, &mesh), 0);
            for (; first < N_TRIANGLES; first = next) {
                next = dx_ros_part_next(p, &mesh, first);
                check_part(p, &mesh, first, next, max);
                n_parts[pass]++;
            }
        }
        assert_int_equal(n_parts[0], n_parts[1]);
        assert_true((n_parts[0] == 1) == (max >= N_VERTICES));
        dx_ros_part_free(p);
    }
    dx_mesh_fini(&mesh);
}

static void an_empty_mesh_is_an_empty_part(void **state)
{
    struct dx_mesh mesh = {0};
    struct dx_ros_part *p;

    (void)state;
    assert_int_equal(dx_ros_part_new(&p, 10), 0);
    assert_int_equal(dx_ros_part_begin(p, &mesh), 0);
    assert_int_equal(dx_ros_part_next(p, &mesh, 0), 0);
    assert_int_equal(p->n_vertices + p->n_indices, 0);
    dx_ros_part_free(p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parts_are_the_mesh),
        cmocka_unit_test(an_empty_mesh_is_an_empty_part),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
