/*
 * What happens to the mesh when the array is turned or mirrored, or the gates are opened
 * (docs/terrain.md: T10, T11).
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "terrain_rig.h"

/* Dexel (i,j) goes to (i, to(j)); orientation is kept, or turned over by a mirror. */
static void move_columns(struct whole_mesh *w, uint32_t width, uint32_t shift, bool mirror)
{
    for (size_t k = 0; k < w->n; k++) {
        uint32_t v[3];

        for (int m = 0; m < 3; m++) {
            const uint32_t i = w->triangle[k].v[m] / width, j = w->triangle[k].v[m] % width;

            v[m] = i * width + (mirror ? width - 1 - j : (j + shift) % width);
        }
        w->triangle[k] = mirror ? rotated(v[0], v[2], v[1]) : rotated(v[0], v[1], v[2]);
    }
    qsort(w->triangle, w->n, sizeof(struct triangle), by_vertices);
}

static void move_plane(struct dx_plane *out, const struct dx_plane *p, uint32_t shift, bool mirror)
{
    for (size_t k = 0; k < dx_plane_n_dexels(p); k++) {
        const size_t i = k / p->width, j = k % p->width;
        const size_t to = mirror ? p->width - 1 - j : (j + shift) % p->width;

        dx_plane_set_range(out, i * p->width + to, dx_plane_range(p, k));
    }
}

static void assert_moves(struct dx_geometry *g, const struct dx_terrain_params *q,
                         const struct dx_plane *p, uint32_t shift, bool mirror)
{
    struct dx_plane moved;
    struct dx_terrain *t, *u;
    struct whole_mesh w, x;

    assert_int_equal(dx_plane_init(&moved, p->height, p->width, p->range_bytes, 0), 0);
    move_plane(&moved, p, shift, mirror);
    t = meshed(g, q, p, NULL);
    u = meshed(g, q, &moved, NULL);
    w = collect(t);
    x = collect(u);
    assert_true(w.n > dx_plane_n_dexels(p) / 4);
    move_columns(&w, p->width, shift, mirror);
    assert_same_mesh(&w, &x);
    free(w.triangle);
    free(x.triangle);
    dx_terrain_free(t);
    dx_terrain_free(u);
    dx_plane_fini(&moved);
}

/* A length in 3-D depends on the rounding of each column's direction: not with a cap. */
static void a_turned_frame_has_the_turned_mesh(void **state)
{
    struct dx_scene_config c;
    struct dx_geometry *g;
    struct dx_plane p;

    (void)state;
    rough_scene(&c, DX_SCENE_HALL, 100, 150);
    g = scene_frame(&c, &p);
    assert_true(g->wrap);
    for (int v = 0; v < N_VARIANTS; v++) {
        struct dx_terrain_params q;

        use_variant(&q, &variants[v]);
        q.sigma_given = true;
        q.sigma[0] = 0.005;
        for (uint32_t shift = 1; q.cap_m == 0 && shift < 150; shift += 37)
            assert_moves(g, &q, &p, shift, false);
    }
    dx_plane_fini(&p);
    dx_geometry_unref(g);
}

static uint32_t gap(const struct dx_plane *p, size_t k, size_t m)
{
    const uint32_t x = dx_plane_range(p, k), y = dx_plane_range(p, m);

    return x < y ? y - x : x - y;
}

/* Steps in depth and noise, without a tie between the diagonals of a cell. */
static void frame_without_ties(struct dx_plane *p, struct dx_rng *rng)
{
    const size_t w = p->width;

    for (size_t k = 0; k < dx_plane_n_dexels(p); k++) {
        const uint32_t step = 400 * (uint32_t)(dx_hash_u64(3, k / w / 9 * 1000 + k % w / 7) % 4);

        dx_plane_set_range(p, k, 20000 + 5 * step + dx_rng_below(rng, 3000));
        if (dx_rng_below(rng, 100) < 8)
            dx_plane_set_range(p, k, 0);
        if (k / w == 0 || k % w == 0 || dx_plane_range(p, k) == 0)
            continue;
        while (gap(p, k, k - w - 1) == gap(p, k - 1, k - w))
            dx_plane_set_range(p, k, dx_plane_range(p, k) + 1);
    }
}

/* A pinhole of exact steps, whose two diagonals have the same constants. */
static void a_mirrored_frame_has_the_mirrored_mesh(void **state)
{
    struct dx_rng rng = dx_rng_init(10, 0);

    (void)state;
    for (int rescue = 0; rescue < 2; rescue++)
        for (uint8_t bridge = 0; bridge < 2; bridge++)
            for (int round = 0; round < 4; round++) {
                struct dx_terrain_params q;
                struct dx_geometry *g;
                struct dx_plane p;

                assert_int_equal(dx_geometry_new_pinhole(&g, 80, 100, 64, 64, 50, 40), 0);
                assert_int_equal(dx_plane_init(&p, 80, 100, 2, 0), 0);
                frame_without_ties(&p, &rng);
                use_variant(&q, &variants[1]);
                q.rescue = rescue;
                q.mixed = rescue ? DX_MIXED_AXIS : DX_MIXED_OFF;
                q.bridge = bridge;
                q.sigma_given = true;
                q.sigma[0] = 0.1;
                assert_moves(g, &q, &p, 0, true);
                dx_plane_fini(&p);
                dx_geometry_unref(g);
            }
}

/* Triangles of each cell of a tile. */
static void count_triangles(uint8_t n[DX_TILE_CELLS * DX_TILE_CELLS], const struct dx_tile *tile)
{
    for (uint32_t k = 0; k < DX_TILE_CELLS * DX_TILE_CELLS; k++)
        n[k] = (uint8_t)((tile->code[k] != DX_CELL_NONE) +
                         (tile->code[k] == DX_CELL_ABC_ACD || tile->code[k] == DX_CELL_ABD_BCD));
}

static void assert_opened(const struct dx_terrain *narrow, const struct dx_terrain *open)
{
    static uint8_t before[DX_TILE_CELLS * DX_TILE_CELLS], after[DX_TILE_CELLS * DX_TILE_CELLS];
    struct dx_tile *tile = malloc(sizeof(*tile));

    assert_non_null(tile);
    for (uint32_t k = 0; k < dx_tiling_n_tiles(dx_terrain_tiling(open)); k++) {
        dx_terrain_tile(narrow, k, tile);
        count_triangles(before, tile);
        dx_terrain_tile(open, k, tile);
        count_triangles(after, tile);
        for (uint32_t c = 0; c < DX_TILE_CELLS * DX_TILE_CELLS; c++)
            assert_true(before[c] <= after[c]);
    }
    free(tile);
}

/* T11: an edge that a gate lets pass, a wider one does too, so no cell loses a triangle. (Which of
 * the two diagonals carries them may change.) Without rescue and mixed pixels, as both look at what
 * is cut. */
static void wider_gates_keep_every_triangle(void **state)
{
    static const double k[] = {0, 1, 2, 4, 4, 4, 8}, tilt[] = {0, 30, 60, 60, 78.69, 85, 89};
    struct dx_scene_config c;

    (void)state;
    for (unsigned s = 0; s < DX_N_SCENES; s++) {
        struct dx_terrain *t[7];
        struct dx_geometry *g;
        struct dx_plane p;

        rough_scene(&c, (enum dx_scene)s, 80, 120);
        g = scene_frame(&c, &p);
        for (int n = 0; n < 7; n++) {
            struct dx_terrain_params q;

            use_variant(&q, &variants[s & 1]);
            q.sigma_given = true;
            q.sigma[0] = 0.005;
            q.noise_k = k[n];
            q.tilt_deg = tilt[n];
            t[n] = meshed(g, &q, &p, NULL);
            if (n > 0)
                assert_opened(t[n - 1], t[n]);
        }
        for (int n = 0; n < 7; n++)
            dx_terrain_free(t[n]);
        dx_plane_fini(&p);
        dx_geometry_unref(g);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_turned_frame_has_the_turned_mesh),
        cmocka_unit_test(a_mirrored_frame_has_the_mirrored_mesh),
        cmocka_unit_test(wider_gates_keep_every_triangle),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
