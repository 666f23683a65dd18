/*
 * Exact streams: vertices are the points of the frame bit for bit, the triangles those of its
 * ranges, and a tile has changed when a point has, be its range the same.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "terrain_rig.h"

#define HEIGHT 70
#define WIDTH  130 /* a full turn: three tiles a row, the last of two columns */

static struct dx_tile tile;
static struct dx_tile_mesh mesh;

/* A turn with drop-outs, and points beside their dexels' axes. */
static struct dx_geometry *exact_frame(struct dx_plane *p)
{
    struct dx_rng rng = dx_rng_init(12, 0);
    struct dx_geometry *g;

    assert_int_equal(
        dx_geometry_new_spinning(&g, HEIGHT, WIDTH, 0, 2 * DX_PI / WIDTH, -0.6, 1.2 / HEIGHT), 0);
    g->exact = true;
    assert_int_equal(dx_plane_init_for(p, g, 0), 0);
    assert_non_null(p->xyz);
    for (uint32_t k = 0; k < HEIGHT * WIDTH; k++) {
        float *x = p->xyz + 3 * (size_t)k;

        if (dx_rng_below(&rng, 20) == 0)
            continue;
        dx_plane_set_range(p, k, 5000 + dx_rng_below(&rng, 20));
        dx_geometry_point(g, k / WIDTH, k % WIDTH, dx_plane_range(p, k), x);
        for (int m = 0; m < 3; m++)
            x[m] += 0.004f * (float)dx_rng_unit(&rng);
    }
    return g;
}

static struct dx_terrain *mesh_of(struct dx_geometry *g, const struct dx_plane *p)
{
    struct dx_terrain_params q;
    struct dx_terrain *t;

    dx_terrain_params_default(&q);
    q.sigma_given = q.normals = true;
    q.sigma[0] = 0.01;
    q.bridge = 2;
    assert_int_equal(dx_terrain_new(&t, g, &q, 0), 0);
    dx_terrain_publish(t, p, 0, WIDTH, NULL);
    dx_terrain_commit(t, NULL);
    return t;
}

static void vertices_are_the_points(void **state)
{
    struct dx_plane p;
    struct dx_geometry *g = exact_frame(&p);
    struct dx_terrain *t = mesh_of(g, &p), *plain;
    uint32_t n_vertices = 0;

    (void)state;
    g->exact = false;
    plain = mesh_of(g, &p);
    for (uint32_t n = 0; n < dx_tiling_n_tiles(dx_terrain_tiling(t)); n++) {
        uint32_t v = 0, n_triangles;

        assert_true(dx_terrain_tile(plain, n, &tile));
        assert_false(tile.exact);
        dx_tile_mesh_build(&mesh, &tile, dx_terrain_tiling(t), g);
        n_triangles = mesh.n_triangles;
        assert_true(dx_terrain_tile(t, n, &tile));
        assert_true(tile.exact);
        dx_tile_mesh_build(&mesh, &tile, dx_terrain_tiling(t), g);
        assert_int_equal(mesh.n_triangles, n_triangles);
        for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
            if (mesh.mask[k / 8] >> (k % 8) & 1) {
                uint64_t id = dx_tile_vertex_id(dx_terrain_tiling(t), tile.row, tile.col, k);

                assert_memory_equal(mesh.xyz + 3 * (size_t)v, p.xyz + 3 * id, 12);
                v++;
            }
        n_vertices += v;
    }
    assert_true(n_vertices > HEIGHT * WIDTH * 9 / 10);
    dx_terrain_free(plain);
    dx_terrain_free(t);
    dx_plane_fini(&p);
    dx_geometry_unref(g);
}

static void a_moved_point_changes_its_tile_alone(void **state)
{
    struct dx_plane p;
    struct dx_geometry *g = exact_frame(&p);
    struct dx_terrain *t = mesh_of(g, &p);
    const size_t k = 30 * WIDTH + 30; /* in the midst of the first tile */

    (void)state;
    assert_true(dx_plane_range(&p, k) != 0);
    dx_terrain_publish(t, &p, 0, WIDTH, NULL);
    assert_int_equal(dx_terrain_commit(t, NULL), 0);
    p.xyz[3 * k] += 0.001f;
    dx_terrain_publish(t, &p, 0, WIDTH, NULL);
    assert_int_equal(dx_terrain_commit(t, NULL), 1);
    assert_int_equal(*dx_terrain_changed(t), 1);
    dx_terrain_free(t);
    dx_plane_fini(&p);
    dx_geometry_unref(g);
}

/* What is published must be a sample. */
static void filters_are_refused(void **state)
{
    struct dx_terrain_params q;
    struct dx_plane p;
    struct dx_geometry *g = exact_frame(&p);
    struct dx_terrain *t;

    (void)state;
    dx_terrain_params_default(&q);
    assert_null(dx_terrain_params_check_exact(&q));
    q.ingest.filter = DX_FILTER_MEAN;
    assert_non_null(dx_terrain_params_check_exact(&q));
    assert_true(dx_terrain_new(&t, g, &q, 0) < 0);
    q.ingest.filter = DX_FILTER_OFF;
    q.ingest.hold = 1;
    assert_non_null(dx_terrain_params_check_exact(&q));
    dx_plane_fini(&p);
    dx_geometry_unref(g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(vertices_are_the_points),
        cmocka_unit_test(a_moved_point_changes_its_tile_alone),
        cmocka_unit_test(filters_are_refused),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
