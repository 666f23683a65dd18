/*
 * Chunks: round trips of random tiles in all encodings, the golden bytes of docs/protocol.md,
 * every truncation, and mutated bytes, which must be refused or give a mesh that can be drawn.
 */
#include <errno.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "tests/unit/rounds.h"
#include "tests/unit/tile_fixture.h"

static struct dx_tile tile;
static struct dx_tile_mesh want, got;
static uint8_t chunk[DX_WIRE_MAX_BODY], of_mesh[DX_WIRE_MAX_BODY];

static size_t encode(enum dx_encoding e, const struct dx_tiling *t, const struct dx_geometry *g)
{
    size_t len;

    dx_tile_mesh_build(&want, &tile, t, g);
    len = fixture_chunk(chunk, e, &tile, t, g);
    assert_true(len <= dx_chunk_max_len(e));
    assert_true(len <= DX_WIRE_MAX_BODY);
    if (e == DX_ENCODING_F32) {
        assert_int_equal(dx_chunk_put_mesh(of_mesh, &want), len);
        assert_memory_equal(of_mesh, chunk, len);
    }
    return len;
}

static void assert_same_mesh(void)
{
    const size_t n = got.n_vertices;

    assert_int_equal(got.row, tile.row);
    assert_int_equal(got.col, tile.col);
    assert_int_equal(got.n_triangles, want.n_triangles);
    assert_memory_equal(got.mask, want.mask, DX_MASK_BYTES);
    if (got.n_triangles == 0)
        return;
    assert_int_equal(got.n_vertices, want.n_vertices);
    assert_int_equal(got.attr_bytes, tile.attr_bytes);
    assert_memory_equal(got.xyz, want.xyz, 12 * n);
    assert_memory_equal(got.index, want.index, 6 * (size_t)want.n_triangles);
    assert_int_equal(got.has_normals, tile.has_normals);
    if (tile.attr_bytes)
        assert_memory_equal(got.attr, want.attr, 2 * n);
    if (tile.has_normals)
        assert_memory_equal(got.normal, want.normal, 2 * n);
}

static void round_trip_grid(uint32_t height, uint32_t width, bool wrap, uint32_t density)
{
    struct dx_geometry *g = fixture_geometry(height, width, wrap);
    struct dx_rng rng = dx_rng_init(height, width + density);
    struct dx_tiling t;

    dx_tiling_init(&t, height, width, wrap);
    for (uint32_t n = 0; n < dx_tiling_n_tiles(&t); n++) {
        for (uint8_t attr_bytes = 0; attr_bytes <= 2; attr_bytes++) {
            fixture_tile(&tile, &t, n, attr_bytes, density, &rng);
            if (dx_rng_below(&rng, 2))
                fixture_normals(&tile, &rng);
            for (int e = 0; e < DX_N_ENCODINGS; e++) {
                size_t len = encode((enum dx_encoding)e, &t, g);

                memset(&got, 0xaa, sizeof(got));
                assert_int_equal(dx_chunk_get(&got, chunk, len, &t, g), 0);
                assert_same_mesh();
            }
        }
    }
    dx_geometry_unref(g);
}

static void test_round_trip(void **state)
{
    static const uint32_t densities[] = {0, 1, 40, 128, 250, 256};

    (void)state;
    for (size_t i = 0; i < sizeof(densities) / sizeof(densities[0]); i++) {
        round_trip_grid(130, 200, true, densities[i]);
        round_trip_grid(130, 200, false, densities[i]);
        round_trip_grid(65, 65, false, densities[i]);
        round_trip_grid(66, 130, true, densities[i]);
        round_trip_grid(2, 9, false, densities[i]);
        round_trip_grid(64, 8, true, densities[i]);
    }
}

static void test_full_tile_lengths(void **state)
{
    struct dx_geometry *g = fixture_geometry(65, 65, false);
    struct dx_tiling t;

    (void)state;
    dx_tiling_init(&t, 65, 65, false);
    for (uint8_t attr_bytes = 0; attr_bytes <= 2; attr_bytes++) {
        struct dx_rng rng = dx_rng_init(1, attr_bytes);

        fixture_tile(&tile, &t, 0, attr_bytes, 256, &rng);
        memset(tile.strut, 0, sizeof(tile.strut));
        for (int i = 0; i < DX_TILE_CELLS * DX_TILE_CELLS; i++)
            tile.code[i] = DX_CELL_ABC_ACD;
        for (int k = 0; k < DX_BLOCK_DEXELS; k++)
            tile.range[k] = 7;
        assert_int_equal(encode(DX_ENCODING_F32, &t, g),
                         10 + 562 + 4225 * (12 + attr_bytes) + 8192 * 6);
        assert_int_equal(encode(DX_ENCODING_Q16, &t, g), 10 + 1536 + 2 + 4225 * (2 + attr_bytes));
        /* a tag a group of eight; no strut; predictor and first range; width 0 in 133 blocks */
        assert_int_equal(encode(DX_ENCODING_DELTA, &t, g),
                         10 + 64 + 2 + 5 + 17 + 4225 * attr_bytes);
    }
    dx_geometry_unref(g);
}

static void test_empty(void **state)
{
    static const uint8_t bytes[] = {0x01, 0x00, 0x02, 0x00, 0x01, 0, 0, 0, 0, 0};
    struct dx_tiling t;

    (void)state;
    dx_tiling_init(&t, 130, 200, true);
    assert_int_equal(dx_chunk_put_empty(chunk, DX_ENCODING_Q16, 1, 2), sizeof(bytes));
    assert_memory_equal(chunk, bytes, sizeof(bytes));
    assert_int_equal(dx_chunk_get(&got, chunk, sizeof(bytes), &t, NULL), 0);
    assert_int_equal(got.n_triangles + got.n_vertices, 0);
    assert_int_equal(got.row, 1);
    assert_int_equal(got.col, 2);
}

/* As printed in docs/protocol.md. */
static void test_golden_bytes(void **state)
{
    static const uint8_t q16[] = {
        0x00, 0x00, 0x00, 0x00, 0x01, 0x00, 0x07, 0x00, 0x05, 0x00, /* header */
        0x73, 0x00,                                                 /* codes 3 6 1 0 */
        0x00, 0x00,                                                 /* no strut */
        0xe8, 0x03, 0xe9, 0x03, 0xea, 0x03, 0xeb, 0x03, 0xec, 0x03, 0xed, 0x03, 0xef, 0x03,
    };
    static const uint8_t f32_header[] = {0, 0, 0, 0, 0, 0, 7, 0, 5, 0};
    static const uint8_t f32_mask[DX_MASK_BYTES] = {[8] = 0x70, [16] = 0x80, 0x03, [25] = 0x08};
    static const uint8_t f32_rest[] = {
        0x00, 0x00, 0x00, 0xbf, 0x00, 0x00, 0x00, 0xbf, 0x00, 0x00, 0x80, 0x3f, /* 1000 */
        0x00, 0x00, 0x00, 0x00, 0xc5, 0x20, 0x00, 0xbf, 0xc5, 0x20, 0x80, 0x3f, /* 1001 */
        0x8a, 0x41, 0x00, 0x3f, 0x8a, 0x41, 0x00, 0xbf, 0x8a, 0x41, 0x80, 0x3f, /* 1002 */
        0x4e, 0x62, 0x00, 0xbf, 0x00, 0x00, 0x00, 0x00, 0x4e, 0x62, 0x80, 0x3f, /* 1003 */
        0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x13, 0x83, 0x80, 0x3f, /* 1004 */
        0xd7, 0xa3, 0x00, 0x3f, 0x00, 0x00, 0x00, 0x00, 0xd7, 0xa3, 0x80, 0x3f, /* 1005 */
        0x00, 0x00, 0x00, 0x00, 0x61, 0xe5, 0x00, 0x3f, 0x61, 0xe5, 0x80, 0x3f, /* 1007 */
        0x00, 0x00, 0x04, 0x00, 0x01, 0x00, 0x00, 0x00, 0x03, 0x00, 0x04, 0x00, /* cell 0,0 */
        0x01, 0x00, 0x04, 0x00, 0x02, 0x00, 0x02, 0x00, 0x04, 0x00, 0x05, 0x00, /* cell 0,1 */
        0x03, 0x00, 0x06, 0x00, 0x04, 0x00,                                     /* cell 1,0 */
    };
    struct dx_geometry *g = fixture_small_geometry();
    struct dx_tiling t;

    (void)state;
    dx_tiling_init(&t, 3, 3, false);
    fixture_small_tile(&tile);
    assert_int_equal(encode(DX_ENCODING_Q16, &t, g), sizeof(q16));
    assert_memory_equal(chunk, q16, sizeof(q16));
    assert_int_equal(encode(DX_ENCODING_F32, &t, g), 10 + DX_MASK_BYTES + sizeof(f32_rest));
    assert_memory_equal(chunk, f32_header, 10);
    assert_memory_equal(chunk + 10, f32_mask, DX_MASK_BYTES);
    assert_memory_equal(chunk + 10 + DX_MASK_BYTES, f32_rest, sizeof(f32_rest));
    dx_geometry_unref(g);
}

/* A chunk in a block of its own size, so that a read past its end shows under ASan. */
static int get_exactly(const uint8_t *bytes, size_t len, const struct dx_tiling *t,
                       const struct dx_geometry *g)
{
    uint8_t *p = malloc(len ? len : 1);
    int r;

    assert_non_null(p);
    memcpy(p, bytes, len);
    r = dx_chunk_get(&got, p, len, t, g);
    free(p);
    return r;
}

static void test_wrong_lengths(void **state)
{
    struct dx_geometry *g = fixture_geometry(20, 30, false);
    struct dx_rng rng = dx_rng_init(3, 4);
    struct dx_tiling t;

    (void)state;
    dx_tiling_init(&t, 20, 30, false);
    for (int e = 0; e < DX_N_ENCODINGS; e++)
        for (uint8_t attr_bytes = 0; attr_bytes <= 2; attr_bytes++) {
            size_t len;

            fixture_tile(&tile, &t, 0, attr_bytes, 200, &rng);
            if (attr_bytes == 1)
                fixture_normals(&tile, &rng);
            len = encode((enum dx_encoding)e, &t, g);
            for (size_t n = 0; n < len + 4; n++)
                assert_int_equal(get_exactly(chunk, n, &t, g), n == len ? 0 : -EBADMSG);
        }
    dx_geometry_unref(g);
}

static void assert_drawable(const struct dx_tiling *t)
{
    uint32_t n = 0;

    assert_true(got.row < t->rows && got.col < t->cols);
    assert_true(got.n_triangles <= DX_TILE_MAX_TRIANGLES);
    for (uint32_t k = 0; k < 8 * DX_MASK_BYTES; k++) {
        if (!(got.mask[k / 8] >> (k % 8) & 1))
            continue;
        assert_true(k < DX_BLOCK_DEXELS);
        assert_true(dx_tile_vertex_id(t, got.row, got.col, k) < (uint64_t)t->height * t->width);
        n++;
    }
    assert_int_equal(n, got.n_vertices);
    for (uint32_t i = 0; i < 3 * got.n_triangles; i++)
        assert_true(got.index[i] < got.n_vertices);
}

static void test_mutations(void **state)
{
    struct dx_geometry *g = fixture_geometry(70, 90, true);
    struct dx_rng rng = dx_rng_init(5, 6);
    struct dx_tiling t;
    uint32_t refused = 0, taken = 0;

    (void)state;
    dx_tiling_init(&t, 70, 90, true);
    for (uint32_t i = 0; i < ROUNDS(20000); i++) {
        const enum dx_encoding e = i % DX_N_ENCODINGS;
        size_t len;

        /* the small tile at the corner, where one byte weighs more */
        fixture_tile(&tile, &t, 3, (uint8_t)(i / 2 % 3), 100, &rng);
        if (i & 8)
            fixture_normals(&tile, &rng);
        len = encode(e, &t, g);
        for (uint32_t m = 0; m <= i % 3; m++) {
            size_t near_start = i % 5 ? len : 40;

            chunk[dx_rng_below(&rng, (uint32_t)near_start)] = (uint8_t)dx_rng_u64(&rng);
        }
        switch (get_exactly(chunk, len, &t, g)) {
        case 0:
            assert_drawable(&t);
            taken++;
            break;
        case -EBADMSG:
            refused++;
            break;
        default:
            fail();
        }
    }
    assert_true(refused > ROUNDS(1000) && taken > ROUNDS(1000));
    dx_geometry_unref(g);
}

/* The flag is in the header, changes no other byte, and outlives a cut; an empty chunk has none. */
static void test_smoothed(void **state)
{
    struct dx_geometry *g = fixture_geometry(70, 90, true);
    struct dx_rng rng = dx_rng_init(3, 0);
    struct dx_chunk_header h;
    struct dx_chunk_cut cut;
    struct dx_tiling t;

    (void)state;
    dx_tiling_init(&t, 70, 90, true);
    for (int e = 0; e < DX_N_ENCODINGS; e++) {
        size_t len;

        fixture_tile(&tile, &t, 1, 1, 150, &rng);
        len = encode((enum dx_encoding)e, &t, g);
        assert_int_equal(dx_chunk_get_header(&h, chunk, len, &t), 0);
        assert_false(h.smoothed);
        dx_chunk_set_smoothed(chunk);
        assert_int_equal(dx_chunk_get_header(&h, chunk, len, &t), 0);
        assert_true(h.smoothed && h.attr_bytes == 1 && !h.has_normals);
        assert_int_equal(dx_chunk_get(&got, chunk, len, &t, g), 0);
        assert_same_mesh();
        dx_chunk_cut(&cut, chunk, (uint32_t)len, 0);
        assert_int_equal(cut.head[DX_CHUNK_SECTIONS_AT], DX_CHUNK_SMOOTHED);
        assert_int_equal(cut.len, len - DX_CHUNK_HEADER_LEN - h.n_vertices);
        len = dx_chunk_put_empty(chunk, (enum dx_encoding)e, 0, 1);
        dx_chunk_set_smoothed(chunk);
        assert_int_equal(dx_chunk_get_header(&h, chunk, len, &t), 0);
        assert_false(h.smoothed);
    }
    dx_geometry_unref(g);
}

/* One field wrong at a time, each of which must be refused. */
static void test_refusals(void **state)
{
    static const struct {
        enum dx_encoding e;
        size_t at;
        uint8_t value;
    } bad[] = {
        {DX_ENCODING_F32, 0, 1},     /* tile row outside the grid */
        {DX_ENCODING_F32, 3, 1},     /* tile column */
        {DX_ENCODING_F32, 4, 3},     /* encoding */
        {DX_ENCODING_F32, 5, 3},     /* both attributes */
        {DX_ENCODING_F32, 5, 16},    /* unknown section */
        {DX_ENCODING_F32, 5, 4},     /* normals that are not there */
        {DX_ENCODING_F32, 6, 6},     /* vertices */
        {DX_ENCODING_F32, 7, 0x12},  /* more vertices than block dexels */
        {DX_ENCODING_F32, 9, 0x23},  /* more triangles than a block has */
        {DX_ENCODING_F32, 10, 1},    /* mask: a dexel before the grid */
        {DX_ENCODING_F32, 18, 0xf0}, /* mask: one dexel more, in a column beyond the grid */
        {DX_ENCODING_F32, 571, 2},   /* mask: a bit beyond the block */
        {DX_ENCODING_F32, 668, 7},   /* index = number of vertices */
        {DX_ENCODING_F32, 669, 0xff}, {DX_ENCODING_Q16, 6, 6},
        {DX_ENCODING_Q16, 8, 4},     /* triangles */
        {DX_ENCODING_Q16, 10, 0x77}, /* code 7 */
        {DX_ENCODING_Q16, 10, 0x70}, /* fewer triangles than the header says */
        {DX_ENCODING_Q16, 11, 0x80}, /* a bit beyond the last code */
        {DX_ENCODING_Q16, 12, 1},    /* a strut that is not there */
        {DX_ENCODING_Q16, 15, 0},    /* with the one before: a range of 0 */
    };
    struct dx_geometry *g = fixture_small_geometry();
    struct dx_tiling t;

    (void)state;
    dx_tiling_init(&t, 3, 3, false);
    fixture_small_tile(&tile);
    for (size_t i = 0; i < sizeof(bad) / sizeof(bad[0]); i++) {
        size_t len = encode(bad[i].e, &t, g);

        assert_int_equal(get_exactly(chunk, len, &t, g), 0);
        chunk[bad[i].at] = bad[i].value;
        if (bad[i].at == 15)
            chunk[14] = 0;
        if (get_exactly(chunk, len, &t, g) != -EBADMSG)
            fail_msg("case %zu was taken", i);
    }
    assert_int_equal(get_exactly(chunk, encode(DX_ENCODING_Q16, &t, g), &t, NULL), -EBADMSG);
    dx_geometry_unref(g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trip),    cmocka_unit_test(test_full_tile_lengths),
        cmocka_unit_test(test_empty),         cmocka_unit_test(test_golden_bytes),
        cmocka_unit_test(test_wrong_lengths), cmocka_unit_test(test_mutations),
        cmocka_unit_test(test_refusals),      cmocka_unit_test(test_smoothed),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
