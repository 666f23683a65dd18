/*
 * Normals in terrain mode: after any updates every tile is, normals included, what a fresh array
 * gives (T9), only tiles that differ are said to have changed, and a vertex on a border has the
 * same bytes in every tile (T7).
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "core/grid/octahedral.h"
#include "terrain_rig.h"

#define HEIGHT 135 /* three rows of tiles, the last of few cells */
#define WIDTH  140

static struct dx_tile tile, fresh_tile;

static void random_dexels(struct dx_plane *p, struct dx_rng *rng, uint32_t n)
{
    for (uint32_t k = 0; k < n; k++) {
        size_t at = dx_rng_below(rng, HEIGHT * WIDTH);

        dx_plane_set_range(p, at, dx_rng_below(rng, 3) ? 4900 + dx_rng_below(rng, 200) : 0);
    }
}

static void assert_borders_agree(const struct dx_terrain *t)
{
    const struct dx_tiling *tiling = dx_terrain_tiling(t);
    int8_t(*seen)[3] = calloc(HEIGHT * WIDTH, sizeof(*seen)); /* third: it was seen */
    uint8_t mask[DX_MASK_BYTES];
    uint32_t n_shared = 0;

    for (uint32_t n = 0; n < dx_tiling_n_tiles(tiling); n++) {
        if (!dx_terrain_tile(t, n, &tile))
            continue;
        assert_true(tile.has_normals);
        dx_tile_mask(&tile, mask);
        for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++) {
            int8_t *s;

            if (!(mask[k / 8] >> (k % 8) & 1))
                continue;
            s = seen[dx_tile_vertex_id(tiling, tile.row, tile.col, k)];
            if (s[2]) {
                assert_memory_equal(s, tile.normal + 2 * (size_t)k, 2);
                n_shared++;
            }
            memcpy(s, tile.normal + 2 * (size_t)k, 2);
            s[2] = 1;
        }
    }
    assert_true(n_shared > 300);
    free(seen);
}

static void updates_equal_from_scratch(void **state)
{
    const int n_rounds = long_run() ? 1000 : 60;
    struct dx_rng rng = dx_rng_init(9, 0);
    struct dx_terrain_params q;
    struct dx_terrain *t, *fresh;
    struct dx_geometry *g;
    struct dx_plane p;
    uint64_t before[9];

    (void)state;
    assert_int_equal(
        dx_geometry_new_spinning(&g, HEIGHT, WIDTH, 0, 2 * DX_PI / WIDTH, -0.6, 1.2 / HEIGHT), 0);
    assert_int_equal(dx_plane_init(&p, HEIGHT, WIDTH, 2, 0), 0);
    for (size_t k = 0; k < dx_plane_n_dexels(&p); k++)
        dx_plane_set_range(&p, k, dx_rng_below(&rng, 10) ? 5000 + dx_rng_below(&rng, 40) : 0);
    dx_terrain_params_default(&q);
    q.sigma_given = q.normals = true;
    q.sigma[0] = 0.01;
    q.bridge = 2;
    q.mixed = DX_MIXED_STRICT;
    assert_int_equal(dx_terrain_new(&t, g, &q, 0), 0);
    assert_int_equal(dx_tiling_n_tiles(dx_terrain_tiling(t)), 9);
    memset(before, 0, sizeof(before));
    for (int round = 0; round < n_rounds; round++) {
        assert_int_equal(dx_terrain_new(&fresh, g, &q, 0), 0);
        dx_terrain_publish(t, &p, 0, WIDTH, NULL);
        dx_terrain_publish(fresh, &p, 0, WIDTH, NULL);
        dx_terrain_commit(t, NULL);
        dx_terrain_commit(fresh, NULL);
        for (uint32_t n = 0; n < 9; n++) {
            uint64_t hash = dx_terrain_tile(t, n, &tile) ? dx_tile_hash(&tile) : 0;

            assert_int_equal(
                hash, dx_terrain_tile(fresh, n, &fresh_tile) ? dx_tile_hash(&fresh_tile) : 0);
            assert_int_equal(*dx_terrain_changed(t) >> n & 1, hash != before[n]);
            before[n] = hash;
        }
        assert_borders_agree(t);
        dx_terrain_free(fresh);
        random_dexels(&p, &rng, 1 + dx_rng_below(&rng, 3));
    }
    dx_terrain_free(t);
    dx_plane_fini(&p);
    dx_geometry_unref(g);
}

/* Every normal faces the scanner's side of its surface: on a sphere seen from its centre, inwards.
 */
static void normals_of_a_sphere_point_inwards(void **state)
{
    struct dx_terrain_params q;
    struct dx_geometry *g;
    struct dx_terrain *t;
    struct dx_plane p;
    static struct dx_tile_mesh mesh;
    uint32_t n_vertices = 0;

    (void)state;
    for (int flip = 0; flip < 2; flip++) {
        assert_int_equal(
            dx_geometry_new_spinning(&g, 60, 90, 0, (flip ? -2 : 2) * DX_PI / 90, -1, 2.0 / 60), 0);
        assert_int_equal(dx_plane_init(&p, 60, 90, 2, 0), 0);
        for (size_t k = 0; k < dx_plane_n_dexels(&p); k++)
            dx_plane_set_range(&p, k, 5000);
        dx_terrain_params_default(&q);
        q.sigma_given = q.normals = true;
        assert_int_equal(dx_terrain_new(&t, g, &q, 0), 0);
        dx_terrain_publish(t, &p, 0, 90, NULL);
        dx_terrain_commit(t, NULL);
        for (uint32_t n = 0; n < dx_tiling_n_tiles(dx_terrain_tiling(t)); n++) {
            assert_true(dx_terrain_tile(t, n, &tile));
            dx_tile_mesh_build(&mesh, &tile, dx_terrain_tiling(t), g);
            for (uint32_t v = 0; v < mesh.n_vertices; v++, n_vertices++) {
                const float *x = mesh.xyz + 3 * (size_t)v;
                float m[3];

                dx_octahedral_decode(m, mesh.normal + 2 * (size_t)v);
                /* 1 in 127 of the square's side, and half a step of the grid at its border */
                assert_true((double)-(m[0] * x[0] + m[1] * x[1] + m[2] * x[2]) > 5 * 0.998);
            }
        }
        dx_terrain_free(t);
        dx_plane_fini(&p);
        dx_geometry_unref(g);
    }
    assert_true(n_vertices > 2 * 60 * 90);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(updates_equal_from_scratch),
        cmocka_unit_test(normals_of_a_sphere_point_inwards),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
