/*
 * What chunks of ranges have besides plain q16: the delta encoding, struts, normals, and cutting
 * sections off. The golden bytes are those of docs/protocol.md.
 */
#include <errno.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "core/base/delta.h"
#include "tests/unit/tile_fixture.h"

static struct dx_tile tile;
static struct dx_tile_mesh want, got;
static uint8_t chunk[DX_WIRE_MAX_BODY];

static size_t encode(enum dx_encoding e, const struct dx_tiling *t, const struct dx_geometry *g)
{
    size_t len;

    dx_tile_mesh_build(&want, &tile, t, g);
    len = fixture_chunk(chunk, e, &tile, t, g);
    assert_true(len <= dx_chunk_max_len(e));
    return len;
}

/* In a block of its own size, so that a read past its end shows under ASan. */
static int get_exactly(const uint8_t *bytes, size_t len, const struct dx_tiling *t,
                       const struct dx_geometry *g)
{
    uint8_t *p = malloc(len);
    int r;

    assert_non_null(p);
    memcpy(p, bytes, len);
    r = dx_chunk_get(&got, p, len, t, g);
    free(p);
    return r;
}

static void assert_same_points(void)
{
    assert_int_equal(got.n_vertices, want.n_vertices);
    assert_int_equal(got.n_triangles, want.n_triangles);
    assert_memory_equal(got.mask, want.mask, DX_MASK_BYTES);
    assert_memory_equal(got.xyz, want.xyz, 12 * (size_t)want.n_vertices);
    assert_memory_equal(got.index, want.index, 6 * (size_t)want.n_triangles);
}

/* ---- ranges --------------------------------------------------------------------------------- */

static void test_32_bit_ranges(void **state)
{
    struct dx_geometry *g = fixture_geometry(130, 200, true);
    struct dx_rng rng = dx_rng_init(7, 8);
    struct dx_tiling t;

    (void)state;
    g->range_bytes = 4;
    dx_tiling_init(&t, 130, 200, true);
    for (uint32_t n = 0; n < 60; n++) {
        /* from smooth to any 32 bits at all, where differences run over */
        uint32_t base = n % 2 ? 0xfffffff0u : 70000, span = n % 3 ? 1u << n % 31 : UINT32_MAX;

        fixture_tile(&tile, &t, n % dx_tiling_n_tiles(&t), 0, n % 4 ? 256 : 20, &rng);
        for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++) {
            tile.range[k] = base + (uint32_t)(dx_rng_u64(&rng) % span);
            tile.range[k] += tile.range[k] == 0;
        }
        assert_int_equal(get_exactly(chunk, encode(DX_ENCODING_DELTA, &t, g), &t, g), 0);
        assert_same_points();
    }
    dx_geometry_unref(g);
}

/* A full tile of ranges by place: the predictor that its chunk names. */
static enum dx_delta_predictor chosen(uint32_t (*range)(uint32_t row, uint32_t col, uint32_t noise),
                                      const struct dx_tiling *t, const struct dx_geometry *g,
                                      size_t *len)
{
    struct dx_rng rng = dx_rng_init(3, 3);

    memset(&tile, 0, sizeof(tile));
    tile.cell_rows = tile.cell_cols = DX_TILE_CELLS;
    memset(tile.code, DX_CELL_ABC_ACD, sizeof(tile.code));
    for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++) {
        uint32_t noise = 0; /* standard deviation 10 */

        for (int m = 0; m < 4; m++)
            noise += dx_rng_below(&rng, 17);
        tile.range[k] = range(k / DX_BLOCK, k % DX_BLOCK, noise);
    }
    *len = encode(DX_ENCODING_DELTA, t, g);
    assert_int_equal(get_exactly(chunk, *len, t, g), 0);
    assert_same_points();
    return chunk[DX_CHUNK_HEADER_LEN + 64 + 2];
}

static uint32_t slope(uint32_t row, uint32_t col, uint32_t noise)
{
    (void)noise;
    return 1000 + 30 * row + 50 * col;
}

static uint32_t wall(uint32_t row, uint32_t col, uint32_t noise)
{
    (void)row, (void)col;
    return 5000 + noise;
}

/* Every row on its own: nothing above helps. */
static uint32_t rows_apart(uint32_t row, uint32_t col, uint32_t noise)
{
    (void)col;
    return 5000 + row * 7919 % 4096 + noise;
}

/* Slanted one way above and the other way below, so that now W and now N is right, and a step
 * across, behind which the sum is wrong. */
static uint32_t step(uint32_t row, uint32_t col, uint32_t noise)
{
    (void)noise;
    return 1000 + 20 * (row < 33 ? row : 33 + col) + (row + col < 65 ? 0 : 4000);
}

static void test_predictors(void **state)
{
    struct dx_geometry *g = fixture_geometry(65, 65, false);
    struct dx_tiling t;
    size_t len;

    (void)state;
    dx_tiling_init(&t, 65, 65, false);
    assert_int_equal(chosen(slope, &t, g, &len), DX_DELTA_PLANAR);
    assert_true(len < 10 + 64 + 2 + 5 + 2000); /* only the first row and column cost anything */
    assert_int_equal(chosen(wall, &t, g, &len), DX_DELTA_MEAN);
    assert_true(len < 10 + 64 + 2 + 5 + 4225 * 13 / 16 + 50); /* 6.5 bits a vertex */
    assert_int_equal(chosen(rows_apart, &t, g, &len), DX_DELTA_LEFT);
    assert_int_equal(chosen(step, &t, g, &len), DX_DELTA_MEDIAN);
    dx_geometry_unref(g);
}

static void test_folding(void **state)
{
    static const uint32_t d[] = {0, UINT32_MAX, 1, UINT32_MAX - 1, 2, INT32_MAX, 1u << 31};
    static const uint32_t z[] = {0, 1, 2, 3, 4, UINT32_MAX - 1, UINT32_MAX};

    (void)state;
    for (size_t k = 0; k < sizeof(d) / sizeof(d[0]); k++) {
        assert_int_equal(dx_delta_fold(d[k]), z[k]);
        assert_int_equal(dx_delta_unfold(z[k]), d[k]);
    }
}

/* ---- golden bytes --------------------------------------------------------------------------- */

static void test_golden_delta(void **state)
{
    static const uint8_t golden[] = {
        0x00, 0x00, 0x00, 0x00, 0x02, 0x00, 0x07, 0x00, 0x05, 0x00, /* header */
        0xf9, 0x00,                                                 /* codes 3 6 / 1 0 */
        0x00, 0x00,                                                 /* no strut */
        0x00, 0xe8, 0x03, 0x00, 0x00,                               /* planar, from 1000 */
        0x3f, 0x48, 0x06, 0x0c,                                     /* width 3: 0 2 2 6 0 0 6 */
    };
    struct dx_geometry *g = fixture_small_geometry();
    struct dx_tiling t;

    (void)state;
    dx_tiling_init(&t, 3, 3, false);
    fixture_small_tile(&tile);
    assert_int_equal(encode(DX_ENCODING_DELTA, &t, g), sizeof(golden));
    assert_memory_equal(chunk, golden, sizeof(golden));
    dx_geometry_unref(g);
}

/* Nine dexels, the one in the middle missing: a strut down with a chain on either side. */
static void strut_tile(void)
{
    const struct dx_strut strut = {.len = 1, .first = DX_STRUT_CHAIN, .second = DX_STRUT_CHAIN};

    fixture_small_tile(&tile);
    tile.code[0] = DX_CELL_ABD;
    tile.code[1] = DX_CELL_ABC;
    tile.code[DX_TILE_CELLS] = DX_CELL_ACD;
    tile.code[DX_TILE_CELLS + 1] = DX_CELL_BCD;
    tile.range[2 * DX_BLOCK + 2] = 0;
    tile.strut[2 * DX_BLOCK + 2] = dx_strut_code(&strut);
    tile.attr_bytes = 1;
    tile.has_normals = true;
    for (uint32_t i = 0; i < 9; i++) {
        uint32_t k = (i / 3 + 1) * DX_BLOCK + i % 3 + 1;

        tile.attr[k] = (uint16_t)(10 * i);
        tile.normal[2 * k] = (int8_t)(i - 4);
        tile.normal[2 * k + 1] = (int8_t)-i;
    }
}

static void test_golden_strut(void **state)
{
    static const uint8_t golden[] = {
        0x00, 0x00, 0x00, 0x00, 0x01, 0x05, 0x08, 0x00, 0x06, 0x00, /* header */
        0x00, 0x0a, 0x14, 0x1e, 0x32, 0x3c, 0x46, 0x50,             /* attributes */
        0x8c, 0x0a,                                                 /* codes 4 1 2 5 */
        0x01, 0x00, 0x88, 0x0d,                                     /* dexel 136, code 13 */
        0xe8, 0x03, 0xe9, 0x03, 0xea, 0x03, 0xeb, 0x03,             /* ranges */
        0xed, 0x03, 0xee, 0x03, 0xef, 0x03, 0xf0, 0x03,             /* */
        0xfc, 0x00, 0xfd, 0xff, 0xfe, 0xfe, 0xff, 0xfd,             /* normals */
        0x01, 0xfb, 0x02, 0xfa, 0x03, 0xf9, 0x04, 0xf8,
    };
    static const uint16_t index[] = {0, 3, 1, 1, 4, 2, 3, 5, 6, 4, 6, 7, 1, 3, 6, 1, 6, 4};
    struct dx_geometry *g = fixture_small_geometry();
    struct dx_tiling t;

    (void)state;
    dx_tiling_init(&t, 3, 3, false);
    strut_tile();
    assert_int_equal(encode(DX_ENCODING_Q16, &t, g), sizeof(golden));
    assert_memory_equal(chunk, golden, sizeof(golden));
    assert_int_equal(want.n_triangles, 6);
    assert_memory_equal(want.index, index, sizeof(index));
    dx_geometry_unref(g);
}

/* ---- struts --------------------------------------------------------------------------------- */

/* 255s between struts far apart: the first, and the last that a block can have. */
static void test_far_struts(void **state)
{
    struct dx_geometry *g = fixture_geometry(65, 65, false);
    const struct dx_strut strut = {.len = 1, .second = DX_STRUT_CHAIN};
    const uint32_t last = 64 * DX_BLOCK + 64;
    struct dx_tiling t;

    (void)state;
    dx_tiling_init(&t, 65, 65, false);
    memset(&tile, 0, sizeof(tile));
    tile.cell_rows = tile.cell_cols = DX_TILE_CELLS;
    for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
        tile.range[k] = k + 1;
    tile.strut[2 * DX_BLOCK + 1] = tile.strut[last] = dx_strut_code(&strut);
    for (enum dx_encoding e = DX_ENCODING_Q16; e < DX_N_ENCODINGS; e++) {
        size_t len = encode(e, &t, g);
        const uint8_t *p = chunk + DX_CHUNK_HEADER_LEN + (e == DX_ENCODING_Q16 ? 1536 : 192);

        assert_int_equal(want.n_vertices, 6);
        assert_int_equal(want.n_triangles, 2);
        assert_int_equal(dx_get_u16(p), 2);
        assert_int_equal(p[2], 135);
        for (uint32_t k = 0; k < (last - 136) / 255; k++)
            assert_int_equal(p[4 + k], 255);
        assert_int_equal(p[4 + (last - 136) / 255], (last - 136) % 255);
        assert_int_equal(get_exactly(chunk, len, &t, g), 0);
        assert_same_points();
    }
    dx_geometry_unref(g);
}

/* ---- refusals ------------------------------------------------------------------------------- */

struct bad {
    size_t at;
    uint8_t value;
};

/* Each case changes one byte of a good chunk. */
static void refuse_all(enum dx_encoding e, const struct bad *bad, size_t n)
{
    struct dx_geometry *g = fixture_small_geometry();
    struct dx_tiling t;

    dx_tiling_init(&t, 3, 3, false);
    for (size_t i = 0; i < n; i++) {
        size_t len = encode(e, &t, g);

        assert_int_equal(get_exactly(chunk, len, &t, g), 0);
        assert_int_not_equal(chunk[bad[i].at], bad[i].value);
        chunk[bad[i].at] = bad[i].value;
        if (get_exactly(chunk, len, &t, g) != -EBADMSG)
            fail_msg("case %zu of %s was taken", i, dx_encoding_name(e));
    }
    dx_geometry_unref(g);
}

static void test_refused_struts(void **state)
{
    static const struct bad bad[] = {
        {5, 1},     /* no normals: the length is wrong */
        {20, 0},    /* no strut, but one follows */
        {20, 2},    /* one strut too many */
        {22, 255},  /* the code is a distance now */
        {22, 1},    /* its owner before the grid */
        {22, 68},   /* an owner whose A is before the grid */
        {22, 133},  /* beside the tile: one end outside the grid */
        {23, 0},    /* codes that no strut has */
        {23, 1},    /* both sides open */
        {23, 221},  /* above the last */
        {23, 14},   /* a side of length 2 */
        {23, 2},    /* one triangle less */
        {23, 0x30}, /* two missing dexels: B outside the grid */
        {40, 0x80}, /* -128 is no coordinate of a normal */
        {55, 0x80},
    };

    (void)state;
    strut_tile();
    refuse_all(DX_ENCODING_Q16, bad, sizeof(bad) / sizeof(bad[0]));
}

static void test_refused_delta(void **state)
{
    static const struct bad bad[] = {
        {4, 3},     /* encoding */
        {4, 1},     /* q16, which it is not */
        {6, 8},     /* vertices */
        {8, 6},     /* triangles */
        {10, 0xff}, /* a code of 7 */
        {11, 0x82}, /* bits after the codes */
        {12, 1},    /* a strut */
        {14, 4},    /* predictor */
        {19, 0xff}, /* a width that is never told */
        {22, 0x91}, /* bits after the ranges */
    };

    (void)state;
    fixture_small_tile(&tile);
    refuse_all(DX_ENCODING_DELTA, bad, sizeof(bad) / sizeof(bad[0]));
}

/* A width of 33, a width of -1, and a range that comes to 0. */
static void test_refused_widths(void **state)
{
    static const uint8_t rest[][12] = {
        {0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x03}, {0x01}, {0x2f}};
    struct dx_geometry *g = fixture_small_geometry();
    struct dx_tiling t;

    (void)state;
    dx_tiling_init(&t, 3, 3, false);
    fixture_small_tile(&tile);
    for (size_t i = 0; i < 3; i++) {
        encode(DX_ENCODING_DELTA, &t, g);
        dx_put_u32(chunk + 15, i == 2 ? 1 : 1000); /* from 1, the residual -1 */
        memcpy(chunk + 19, rest[i], sizeof(rest[i]));
        for (size_t len = 19; len < 19 + sizeof(rest[i]); len++)
            assert_int_equal(get_exactly(chunk, len, &t, g), -EBADMSG);
    }
    dx_geometry_unref(g);
}

/* ---- cutting -------------------------------------------------------------------------------- */

static void test_cut(void **state)
{
    struct dx_geometry *g = fixture_geometry(70, 90, true);
    struct dx_rng rng = dx_rng_init(1, 1);
    static uint8_t cut[DX_WIRE_MAX_BODY];
    struct dx_tiling t;

    (void)state;
    dx_tiling_init(&t, 70, 90, true);
    for (uint32_t k = 0; k < 3 * DX_N_ENCODINGS * 8; k++) {
        uint8_t keep = k % 8 & 1 ? 7 : k % 8 & 6; /* 7, or attributes and normals by choice */
        struct dx_chunk_cut c;
        size_t len;

        fixture_tile(&tile, &t, k % 4, (uint8_t)(k / 8 % 3), 150, &rng);
        if (k % 5)
            fixture_normals(&tile, &rng);
        keep = keep & 2 ? keep | 1 : keep;
        len = encode(k / 24 % DX_N_ENCODINGS, &t, g);
        dx_chunk_cut(&c, chunk, (uint32_t)len, keep);
        memcpy(cut, c.head, DX_CHUNK_HEADER_LEN);
        memcpy(cut + DX_CHUNK_HEADER_LEN, chunk + c.skip, c.len);
        assert_int_equal(get_exactly(cut, DX_CHUNK_HEADER_LEN + c.len, &t, g), 0);
        assert_same_points();
        assert_int_equal(got.attr_bytes, keep & 2 ? tile.attr_bytes : 0);
        assert_int_equal(got.has_normals, keep & DX_CHUNK_NORMALS && tile.has_normals);
        if (got.attr_bytes)
            assert_memory_equal(got.attr, want.attr, 2 * (size_t)want.n_vertices);
        if (got.has_normals)
            assert_memory_equal(got.normal, want.normal, 2 * (size_t)want.n_vertices);
    }
    dx_geometry_unref(g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_32_bit_ranges),  cmocka_unit_test(test_predictors),
        cmocka_unit_test(test_folding),        cmocka_unit_test(test_golden_delta),
        cmocka_unit_test(test_golden_strut),   cmocka_unit_test(test_far_struts),
        cmocka_unit_test(test_refused_struts), cmocka_unit_test(test_refused_delta),
        cmocka_unit_test(test_refused_widths), cmocka_unit_test(test_cut),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
