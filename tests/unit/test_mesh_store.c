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
        p->id[k] = id[k];
        p->xyz[3 * k] = (float)(id[k] % WIDTH);
        p->xyz[3 * k + 1] = (float)(id[k] / WIDTH);
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
    dx_mesh_fini(&m);
    tile.n_vertices = 4; /* not what the mask says */
    assert_int_equal(dx_mesh_store_set_mesh(s, &tile), -EBADMSG);
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
        cmocka_unit_test(test_refuses_what_does_not_fit),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
