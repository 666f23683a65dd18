/*
 * Normals: octahedral bytes there and back, and the sums of a grid of random tiles against a vertex
 * by vertex reference in the documented order, bit for bit in every tile that has the vertex.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "core/grid/normals.h"
#include "core/grid/octahedral.h"
#include "tests/unit/tile_fixture.h"

/* ---- octahedral ----------------------------------------------------------------------------- */

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void test_axes(void **state)
{
    static const float axis[][3] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                    {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};

    (void)state;
    for (size_t k = 0; k < 6; k++) {
        const float far[3] = {1e20f * axis[k][0], 1e20f * axis[k][1], 1e20f * axis[k][2]};
        int8_t q[2], again[2];
        float n[3];

        dx_octahedral_encode(q, axis[k]);
        dx_octahedral_decode(n, q);
        for (int m = 0; m < 3; m++)
            assert_true(n[m] == axis[k][m]);
        dx_octahedral_encode(again, far); /* length does not matter */
        assert_memory_equal(again, q, 2);
    }
}

static void test_no_direction(void **state)
{
    static const float none[][3] = {{0, 0, 0}, {NAN, 1, 1}, {INFINITY, 0, 1}};

    (void)state;
    for (size_t k = 0; k < 3; k++) {
        int8_t q[2] = {5, 5};

        dx_octahedral_encode(q, none[k]);
        assert_int_equal(q[0] | q[1], 0);
    }
}

static void test_random_directions(void **state)
{
    struct dx_rng rng = dx_rng_init(1, 2);
    float worst = 1;

    (void)state;
    for (int k = 0; k < 20000; k++) {
        float v[3], n[3], len;
        int8_t q[2];

        for (int m = 0; m < 3; m++)
            v[m] = (float)dx_rng_below(&rng, 20001) - 10000;
        len = sqrtf(dot(v, v));
        if (len == 0)
            continue;
        dx_octahedral_encode(q, v);
        dx_octahedral_decode(n, q);
        assert_true(fabsf(dot(n, n) - 1) < 1e-6f);
        worst = fminf(worst, dot(n, v) / len);
    }
    assert_true(worst > 0.99985f); /* one degree */
}

/* As printed in docs/protocol.md. */
static void test_golden_decode(void **state)
{
    static const struct {
        int8_t q[2];
        uint32_t bits[3];
    } golden[] = {
        {{40, -28}, {0x3f05b5ec, 0xbebb31e4, 0x3f453923}},
        {{-100, 90}, {0xbef33639, 0x3eb17a9a, 0xbf4f0f08}},
    };

    (void)state;
    for (size_t k = 0; k < 2; k++) {
        float n[3];

        dx_octahedral_decode(n, golden[k].q);
        for (int m = 0; m < 3; m++)
            assert_int_equal(dx_f32_bits(n[m]), golden[k].bits[m]);
    }
}

/* ---- sums ----------------------------------------------------------------------------------- */

#define HEIGHT 140 /* 3 tile rows; with 150 columns 3 tile columns, wrapped or not */
#define WIDTH  150

struct world {
    struct dx_geometry *g;
    struct dx_plane plane;
    struct dx_tiling t;
    struct dx_tile tile[9];
    struct dx_normals_source source;
};

static const uint8_t *cells_of(const void *ctx, uint32_t tile)
{
    return ((const struct world *)ctx)->tile[tile].code;
}

static const uint8_t *struts_of(const void *ctx, uint32_t tile)
{
    const struct dx_tile *t = &((const struct world *)ctx)->tile[tile];

    return dx_strut_next(t->strut, 0) < DX_BLOCK_DEXELS ? t->strut : NULL;
}

static struct world *world_new(bool wrap, bool flip, uint32_t density, uint32_t range_span)
{
    struct world *w = calloc(1, sizeof(*w));
    struct dx_rng rng = dx_rng_init(density, wrap);

    assert_non_null(w);
    w->g = fixture_geometry(HEIGHT, WIDTH, wrap);
    w->g->flip = flip;
    dx_tiling_init(&w->t, HEIGHT, WIDTH, wrap);
    assert_int_equal(dx_tiling_n_tiles(&w->t), 9);
    assert_int_equal(dx_plane_init(&w->plane, HEIGHT, WIDTH, 2, 0), 0);
    for (size_t k = 0; k < HEIGHT * WIDTH; k++)
        dx_plane_set_range(&w->plane, k, 5000 + dx_rng_below(&rng, range_span));
    for (uint32_t n = 0; n < 9; n++)
        fixture_tile(&w->tile[n], &w->t, n, 0, density, &rng);
    w->source = (struct dx_normals_source){&w->plane, &w->t, w->g, w, cells_of, struts_of};
    return w;
}

static void world_free(struct world *w)
{
    dx_plane_fini(&w->plane);
    dx_geometry_unref(w->g);
    free(w);
}

static void point_of(const struct world *w, int64_t row, int64_t col, float p[3])
{
    uint32_t j = (uint32_t)((col + WIDTH) % WIDTH);

    dx_geometry_point(w->g, (uint32_t)row, j, dx_plane_range(&w->plane, (size_t)row * WIDTH + j),
                      p);
}

/* Adds the triangle when the vertex is one of its corners; corners in columns not yet modulo. */
static void add_if_at(float sum[3], const struct world *w, const int64_t c[3][2], int64_t row,
                      int64_t col)
{
    float p[3][3], u[3], v[3];
    bool at = false;

    for (int m = 0; m < 3; m++) {
        at |= c[m][0] == row && c[m][1] == col;
        point_of(w, c[m][0], c[m][1], p[w->g->flip && m ? 3 - m : m]);
    }
    if (!at)
        return;
    for (int k = 0; k < 3; k++) {
        u[k] = p[1][k] - p[0][k];
        v[k] = p[2][k] - p[0][k];
    }
    sum[0] += u[1] * v[2] - u[2] * v[1];
    sum[1] += u[2] * v[0] - u[0] * v[2];
    sum[2] += u[0] * v[1] - u[1] * v[0];
}

static void add_cell(float sum[3], const struct world *w, int64_t i, int64_t j, int64_t row,
                     int64_t col)
{
    static const char *const triangles[7] = {"", "abc", "acd", "abcacd", "abd", "bcd", "abdbcd"};
    const int64_t at[4][2] = {{i, j}, {i, j + 1}, {i + 1, j + 1}, {i + 1, j}};
    int64_t jj = (j + WIDTH) % WIDTH;
    const char *p;

    if (i < 0 || i >= w->t.cell_rows || (!w->t.wrap && (j < 0 || j >= w->t.cell_cols)))
        return;
    p = triangles[w->tile[i / 64 * 3 + jj / 64].code[i % 64 * 64 + jj % 64]];
    for (; *p; p += 3) {
        int64_t c[3][2];

        for (int m = 0; m < 3; m++)
            memcpy(c[m], at[p[m] - 'a'], sizeof(c[m]));
        add_if_at(sum, w, (const int64_t(*)[2])c, row, col);
    }
}

static void add_strut(float sum[3], const struct world *w, int64_t i, int64_t j, int64_t row,
                      int64_t col)
{
    struct dx_strut_corner t[DX_STRUT_MAX_TRIANGLES][3];
    int64_t jj = (j + WIDTH) % WIDTH, ti, tj;
    unsigned n;

    if (i < 0 || i >= HEIGHT || (!w->t.wrap && (j < 0 || j >= WIDTH)))
        return;
    ti = i / 64 < 2 ? i / 64 : 2;
    tj = jj / 64 < 2 ? jj / 64 : 2;
    n = dx_strut_triangles(
        t, w->tile[ti * 3 + tj].strut[(i - 64 * ti + 1) * DX_BLOCK + jj - 64 * tj + 1]);
    for (unsigned k = 0; k < n; k++) {
        int64_t c[3][2];

        for (int m = 0; m < 3; m++) {
            c[m][0] = i + t[k][m].row;
            c[m][1] = j + t[k][m].col;
        }
        add_if_at(sum, w, (const int64_t(*)[2])c, row, col);
    }
}

static void reference(int8_t q[2], const struct world *w, int64_t row, int64_t col)
{
    float sum[3] = {0, 0, 0};

    for (int64_t k = 0; k < 4; k++)
        add_cell(sum, w, row - 1 + k / 2, col - 1 + k % 2, row, col);
    for (int64_t i = row - 2; i <= row + 1; i++)
        for (int64_t j = col - 2; j <= col + 1; j++)
            add_strut(sum, w, i, j, row, col);
    dx_octahedral_encode(q, sum);
}

static void check_world(struct world *w)
{
    size_t n_struts = 0;

    for (uint32_t n = 0; n < 9; n++) {
        struct dx_tile *tile = &w->tile[n];
        uint8_t mask[DX_MASK_BYTES];

        dx_tile_mask(tile, mask);
        dx_normals_compute(tile, &w->source);
        assert_true(tile->has_normals);
        for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++) {
            uint64_t id = dx_tile_vertex_id(&w->t, tile->row, tile->col, k);
            int8_t want[2] = {0, 0};

            n_struts += tile->strut[k] != 0;
            if (mask[k / 8] >> (k % 8) & 1)
                reference(want, w, (int64_t)(id / WIDTH), (int64_t)(id % WIDTH));
            assert_memory_equal(tile->normal + 2 * k, want, 2);
        }
    }
    assert_true(n_struts > 100);
}

static void test_sums_in_order(void **state)
{
    (void)state;
    for (int k = 0; k < 4; k++) {
        struct world *w = world_new(k & 1, k & 2, k < 2 ? 60 : 200, 3000);

        check_world(w);
        world_free(w);
    }
}

/* A sphere around the scanner: its normals point to the centre, also on borders, seam and edges. */
static void test_sphere(void **state)
{
    struct world *w = world_new(true, false, 0, 1);

    (void)state;
    dx_geometry_orient(w->g);
    for (uint32_t n = 0; n < 9; n++)
        for (uint32_t i = 0; i < w->tile[n].cell_rows; i++)
            memset(w->tile[n].code + DX_TILE_CELLS * i, DX_CELL_ABC_ACD, w->tile[n].cell_cols);
    for (uint32_t n = 0; n < 9; n++) {
        struct dx_tile *tile = &w->tile[n];

        dx_normals_compute(tile, &w->source);
        for (uint32_t i = 0; i <= tile->cell_rows; i++)
            for (uint32_t j = 0; j <= tile->cell_cols; j++) {
                uint32_t k = (i + 1) * DX_BLOCK + j + 1;
                uint64_t id = dx_tile_vertex_id(&w->t, tile->row, tile->col, k);
                float p[3], m[3];

                point_of(w, (int64_t)(id / WIDTH), (int64_t)(id % WIDTH), p);
                dx_octahedral_decode(m, tile->normal + 2 * k);
                assert_true(dot(m, p) < -0.999f * 5); /* within 2.6 degrees; 5 m */
            }
    }
    world_free(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_axes),
        cmocka_unit_test(test_no_direction),
        cmocka_unit_test(test_random_directions),
        cmocka_unit_test(test_golden_decode),
        cmocka_unit_test(test_sums_in_order),
        cmocka_unit_test(test_sphere),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
