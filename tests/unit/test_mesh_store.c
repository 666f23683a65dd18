/* The tile store: replace, remove, reset, whole epochs, welding, and what it refuses. */
#include "tools/mesh_store.h"

#include <errno.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>
#include <cmocka.h>

#define WIDTH 130 /* 3 tiles across without wrap: cells 64 + 64 + 1 */

/* One cell (two triangles) whose corner a is dexel (row, col), in tile (0, tile_col). */
struct patch {
    float xyz[12];
    uint32_t id[4];
    uint16_t attr[4], index[6];
};

static struct dx_store_tile patch_tile(struct patch *p, uint32_t tile_col, uint32_t col, float z)
{
    uint32_t id[4] = {col, col + 1, WIDTH + col, WIDTH + col + 1};

    *p = (struct patch){.index = {0, 1, 3, 0, 3, 2}};
    for (int k = 0; k < 4; k++) {
        const uint32_t y = id[k] / WIDTH;

        p->id[k] = id[k];
        p->xyz[3 * k] = (float)(id[k] % WIDTH);
        p->xyz[3 * k + 1] = (float)y;
        p->xyz[3 * k + 2] = z;
        p->attr[k] = (uint16_t)(100 + id[k]);
    }
    return (struct dx_store_tile){.row = 0,
                                  .col = tile_col,
                                  .n_vertices = 4,
                                  .n_triangles = 2,
                                  .xyz = p->xyz,
                                  .index = p->index,
                                  .id = p->id,
                                  .attr = p->attr};
}

static struct dx_mesh_store *new_store(void)
{
    struct dx_mesh_store *s;

    assert_int_equal(dx_mesh_store_new(&s, 3, WIDTH, false, 2), 0);
    return s;
}

static void set(struct dx_mesh_store *s, uint32_t tile_col, uint32_t col, float z)
{
    struct patch p;
    struct dx_store_tile t = patch_tile(&p, tile_col, col, z);

    assert_int_equal(dx_mesh_store_set(s, &t), 0);
}

static void test_welds_in_id_order(void **state)
{
    struct dx_mesh_store *s = new_store();
    struct dx_mesh m;
    /* Cells at columns 63 and 64 are neighbours in two tiles: they share dexels 64 and 194. */
    static const uint32_t id[] = {63, 64, 65, 193, 194, 195};
    static const uint32_t index[] = {0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4};

    (void)state;
    set(s, 1, 64, 1);
    set(s, 0, 63, 1);
    dx_mesh_store_commit(s);
    assert_int_equal(dx_mesh_store_n_triangles(s), 4);
    assert_int_equal(dx_mesh_store_n_tile_vertices(s), 8);
    assert_int_equal(dx_mesh_store_n_tiles(s), 2);
    assert_int_equal(dx_mesh_store_weld(&m, s), 0);
    assert_int_equal(m.n_vertices, 6);
    assert_int_equal(m.n_triangles, 4);
    assert_memory_equal(m.id, id, sizeof(id));
    assert_memory_equal(m.index, index, sizeof(index));
    for (int v = 0; v < 6; v++) {
        assert_true(m.xyz[3 * v] == (float)(id[v] % WIDTH));
        assert_int_equal(m.attr[v], 100 + id[v]);
    }
    dx_mesh_fini(&m);
    dx_mesh_store_free(s);
}

static void test_replaces_removes_and_resets(void **state)
{
    struct dx_mesh_store *s = new_store();
    struct dx_store_tile empty = {.row = 0, .col = 0};
    struct dx_mesh m;

    (void)state;
    set(s, 0, 10, 1);
    set(s, 1, 70, 1);
    dx_mesh_store_commit(s);
    set(s, 0, 20, 2);
    set(s, 0, 30, 3); /* twice in one batch: the later one */
    dx_mesh_store_commit(s);
    assert_int_equal(dx_mesh_store_n_triangles(s), 4);
    assert_int_equal(dx_mesh_store_weld(&m, s), 0);
    assert_int_equal(m.id[0], 30);
    dx_mesh_fini(&m);
    assert_int_equal(dx_mesh_store_set(s, &empty), 0);
    dx_mesh_store_commit(s);
    assert_int_equal(dx_mesh_store_n_triangles(s), 2);
    assert_int_equal(dx_mesh_store_n_tiles(s), 1);
    set(s, 2, 128, 1);
    dx_mesh_store_reset(s);
    dx_mesh_store_commit(s);
    assert_int_equal(dx_mesh_store_n_triangles(s), 0);
    assert_int_equal(dx_mesh_store_weld(&m, s), 0);
    assert_int_equal(m.n_vertices, 0);
    dx_mesh_fini(&m);
    dx_mesh_store_free(s);
}

static void test_holds_the_whole_epoch_until_commit(void **state)
{
    struct dx_mesh_store *s = new_store();
    struct dx_mesh m;

    (void)state;
    set(s, 0, 10, 1);
    dx_mesh_store_commit(s);
    dx_mesh_store_reset(s);
    set(s, 1, 70, 1);
    assert_int_equal(dx_mesh_store_weld(&m, s), 0);
    assert_int_equal(m.n_triangles, 2);
    assert_int_equal(m.id[0], 10);
    dx_mesh_fini(&m);
    dx_mesh_store_commit(s);
    assert_int_equal(dx_mesh_store_weld(&m, s), 0);
    assert_int_equal(m.n_triangles, 2);
    assert_int_equal(m.id[0], 70);
    dx_mesh_fini(&m);
    dx_mesh_store_free(s);
}

static void test_leaves_out_unused_vertices(void **state)
{
    struct dx_mesh_store *s = new_store();
    struct patch p;
    struct dx_store_tile t = patch_tile(&p, 0, 5, 1);
    static const uint32_t index[] = {0, 1, 2};
    struct dx_mesh m;

    (void)state;
    t.n_triangles = 1; /* 0, 1, 3: vertex 2 is left over */
    assert_int_equal(dx_mesh_store_set(s, &t), 0);
    dx_mesh_store_commit(s);
    assert_int_equal(dx_mesh_store_weld(&m, s), 0);
    assert_int_equal(m.n_vertices, 3);
    assert_int_equal(m.id[2], WIDTH + 6);
    assert_memory_equal(m.index, index, sizeof(index));
    dx_mesh_fini(&m);
    dx_mesh_store_free(s);
}

static void test_first_tile_wins_a_dispute(void **state)
{
    struct dx_mesh_store *s = new_store();
    struct dx_mesh m;

    (void)state;
    set(s, 0, 63, 1);
    set(s, 1, 64, 2);
    dx_mesh_store_commit(s);
    assert_int_equal(dx_mesh_store_weld(&m, s), 0);
    assert_true(m.xyz[3 * 1 + 2] == 1); /* dexel 64 */
    assert_true(m.xyz[3 * 2 + 2] == 2); /* dexel 65 */
    dx_mesh_fini(&m);
    dx_mesh_store_free(s);
}

static void test_takes_a_grid_tile(void **state)
{
    struct dx_mesh_store *s = new_store();
    static struct dx_tile_mesh tile;
    struct dx_mesh m;

    (void)state;
    tile = (struct dx_tile_mesh){.row = 0, .col = 1, .n_vertices = 3, .n_triangles = 1};
    tile.xyz[0] = 7;
    tile.has_normals = true;
    tile.normal[2] = 127; /* of the second: (1, 0, 0) */
    tile.index[1] = 1;
    tile.index[2] = 2;
    /* Block dexels (1,1), (1,2), (2,1): the corners a, b, d of the tile's first cell. */
    for (int k = 0; k < 3; k++) {
        int bit = (int[]){DX_BLOCK + 1, DX_BLOCK + 2, 2 * DX_BLOCK + 1}[k];

        tile.mask[bit / 8] = (uint8_t)(tile.mask[bit / 8] | 1 << bit % 8);
    }
    assert_int_equal(dx_mesh_store_set_mesh(s, &tile), 0);
    dx_mesh_store_commit(s);
    assert_int_equal(dx_mesh_store_weld(&m, s), 0);
    assert_int_equal(m.n_vertices, 3);
    assert_int_equal(m.id[0], 64);
    assert_int_equal(m.id[1], 65);
    assert_int_equal(m.id[2], WIDTH + 64);
    assert_true(m.xyz[0] == 7);
    assert_true(m.normal[2] == 1 && m.normal[3] == 1 && m.normal[5] == 0);
    dx_mesh_fini(&m);
    tile.n_vertices = 4; /* not what the mask says */
    assert_int_equal(dx_mesh_store_set_mesh(s, &tile), -EBADMSG);
    dx_mesh_store_free(s);
}

/* ---- caps and normals ----------------------------------------------------------------------- */

/* A ring of 8 columns and 2 rows, all cells full, normals on request. */
static struct dx_mesh_store *ring_store(uint32_t n_cells, const float *normal)
{
    static const uint32_t id[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    static const float xyz[48];
    uint16_t index[48];
    struct dx_mesh_store *s;

    for (uint16_t j = 0; j < 8; j++) {
        const uint16_t k = (uint16_t)((j + 1) % 8);
        const uint16_t cell[6] = {j, k, (uint16_t)(k + 8), j, (uint16_t)(k + 8), (uint16_t)(j + 8)};

        memcpy(index + 6 * j, cell, sizeof(cell));
    }
    assert_int_equal(dx_mesh_store_new(&s, 2, 8, true, 0), 0);
    assert_int_equal(dx_mesh_store_set(s, &(struct dx_store_tile){.n_vertices = 16,
                                                                  .n_triangles = 2 * n_cells,
                                                                  .xyz = xyz,
                                                                  .index = index,
                                                                  .id = id,
                                                                  .normal = normal}),
                     0);
    return s;
}

static void assert_weld(const struct dx_mesh_store *s, uint32_t n_triangles, const uint32_t *tail,
                        size_t n_tail)
{
    struct dx_mesh m;

    assert_int_equal(dx_mesh_store_weld(&m, s), 0);
    assert_int_equal(m.n_triangles, n_triangles);
    if (n_tail)
        assert_memory_equal(m.index + 3 * (n_triangles - n_tail), tail, 12 * n_tail);
    dx_mesh_fini(&m);
}

static void test_caps(void **state)
{
    static const uint32_t both[12][3] = {{0, 2, 1},   {0, 3, 2},   {0, 4, 3},   {0, 5, 4},
                                         {0, 6, 5},   {0, 7, 6},   {8, 9, 10},  {8, 10, 11},
                                         {8, 11, 12}, {8, 12, 13}, {8, 13, 14}, {8, 14, 15}};
    static const uint32_t flipped[6][3] = {{8, 10, 9},  {8, 11, 10}, {8, 12, 11},
                                           {8, 13, 12}, {8, 14, 13}, {8, 15, 14}};
    struct dx_mesh_store *s = ring_store(8, NULL);

    (void)state;
    dx_mesh_store_set_caps(s, true, true, false);
    assert_weld(s, 0, NULL, 0); /* not before the commit */
    dx_mesh_store_commit(s);
    assert_weld(s, 16 + 12, both[0], 12);
    assert_int_equal(dx_mesh_store_n_triangles(s), 16);
    dx_mesh_store_commit(s); /* as before */
    assert_weld(s, 16 + 12, both[0], 12);
    dx_mesh_store_set_caps(s, false, true, true);
    dx_mesh_store_commit(s);
    assert_weld(s, 16 + 6, flipped[0], 6);
    dx_mesh_store_reset(s);
    dx_mesh_store_commit(s);
    assert_weld(s, 0, NULL, 0);
    dx_mesh_store_free(s);

    s = ring_store(6, NULL); /* dexel 7 is missing: no fan without it */
    dx_mesh_store_set_caps(s, true, true, false);
    dx_mesh_store_commit(s);
    assert_weld(s, 12, NULL, 0);
    dx_mesh_store_free(s);
}

/* With its caps the ring is closed: every edge has two triangles that run it both ways. */
static void test_caps_close_the_ring(void **state)
{
    struct dx_mesh_store *s = ring_store(8, NULL);
    int8_t edge[16][16] = {{0}};
    struct dx_mesh m;

    (void)state;
    dx_mesh_store_set_caps(s, true, true, false);
    dx_mesh_store_commit(s);
    assert_int_equal(dx_mesh_store_weld(&m, s), 0);
    for (uint32_t k = 0; k < 3 * m.n_triangles; k++)
        edge[m.index[k]][m.index[k % 3 == 2 ? k - 2 : k + 1]]++;
    for (int a = 0; a < 16; a++)
        for (int b = 0; b < 16; b++) {
            assert_true(edge[a][b] <= 1);
            assert_int_equal(edge[a][b], edge[b][a]);
        }
    dx_mesh_fini(&m);
    dx_mesh_store_free(s);
}

static void test_normals_of_all_or_none(void **state)
{
    struct dx_mesh_store *s;
    float normal[48];
    struct dx_mesh m;

    (void)state;
    for (int k = 0; k < 48; k++)
        normal[k] = (float)k;
    s = ring_store(8, normal);
    dx_mesh_store_commit(s);
    assert_int_equal(dx_mesh_store_weld(&m, s), 0);
    assert_memory_equal(m.normal, normal, sizeof(normal));
    dx_mesh_fini(&m);
    dx_mesh_store_free(s);

    s = ring_store(8, NULL);
    dx_mesh_store_commit(s);
    assert_int_equal(dx_mesh_store_weld(&m, s), 0);
    assert_null(m.normal);
    dx_mesh_fini(&m);
    dx_mesh_store_free(s);
}

static void test_refuses_what_does_not_fit(void **state)
{
    struct dx_mesh_store *s = new_store(), *none;
    struct patch p;
    struct dx_store_tile t = patch_tile(&p, 3, 5, 1);

    (void)state;
    assert_int_equal(dx_mesh_store_set(s, &t), -EBADMSG); /* tile column */
    t.col = 0;
    t.row = 1;
    assert_int_equal(dx_mesh_store_set(s, &t), -EBADMSG);
    t.row = 0;
    p.id[3] = 3 * WIDTH;
    assert_int_equal(dx_mesh_store_set(s, &t), -EBADMSG);
    p.id[3] = 0;
    p.index[5] = 4;
    assert_int_equal(dx_mesh_store_set(s, &t), -EBADMSG);
    p.index[5] = 3;
    t.n_triangles = DX_TILE_MAX_TRIANGLES + 1;
    assert_int_equal(dx_mesh_store_set(s, &t), -EBADMSG);
    t.n_triangles = 2;
    t.n_vertices = DX_TILE_MAX_VERTICES + 1;
    assert_int_equal(dx_mesh_store_set(s, &t), -EBADMSG);
    dx_mesh_store_free(s);
    assert_int_equal(dx_mesh_store_new(&none, 65535, 65535, false, 0), -EINVAL);
    assert_int_equal(dx_mesh_store_new(&none, 0, 8, false, 0), -EINVAL);
    assert_null(none);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_welds_in_id_order),
        cmocka_unit_test(test_replaces_removes_and_resets),
        cmocka_unit_test(test_holds_the_whole_epoch_until_commit),
        cmocka_unit_test(test_leaves_out_unused_vertices),
        cmocka_unit_test(test_first_tile_wins_a_dispute),
        cmocka_unit_test(test_takes_a_grid_tile),
        cmocka_unit_test(test_caps),
        cmocka_unit_test(test_caps_close_the_ring),
        cmocka_unit_test(test_normals_of_all_or_none),
        cmocka_unit_test(test_refuses_what_does_not_fit),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
