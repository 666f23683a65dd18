/*
 * The Kinect's codes to depths: unpacking, the table of millimetres against published values,
 * blocks to frames, holes, changed devices, hostile blocks.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "core/base/bytes.h"
#include "drivers/kinect/kinect_decode.h"
#include "tests/hil/kinect_sim.h"

#include <math.h>
#include <stdlib.h>

static const struct dx_kinect_constants usual = {7.5f, 2.3f, 120.0f, 0.1042f, 200};

static void the_known_bytes_unpack(void **state)
{
    static const uint8_t packed[11] = {0, 0, 4, 1, 0x2b, 0xc6, 0x40, 0xfa, 0x1f, 0xff, 0xff};
    static const uint16_t codes[8] = {0, 1, 2, 700, 800, 1000, 1023, 2047};
    uint16_t same[DX_KINECT_N_CODES], out[8];

    (void)state;
    for (uint16_t k = 0; k < DX_KINECT_N_CODES; k++)
        same[k] = k;
    dx_kinect_unpack(out, packed, 8, 11, same);
    assert_memory_equal(out, codes, sizeof(codes));
}

/* Against the packing of the simulated camera, which goes bit by bit. */
static void all_codes_unpack(void **state)
{
    static uint16_t codes[4096], out[4096], same[DX_KINECT_N_CODES];
    static uint8_t packed[4096 * 11 / 8];

    (void)state;
    for (uint16_t k = 0; k < DX_KINECT_N_CODES; k++)
        same[k] = k;
    for (int bits = 10; bits <= 11; bits++) {
        for (uint32_t k = 0; k < 4096; k++)
            codes[k] = (uint16_t)(k * 2654435761u >> (32 - bits));
        kinect_sim_pack(packed, codes, 4096, bits);
        memset(out, 0, sizeof(out));
        dx_kinect_unpack(out, packed, 4096, bits, same);
        assert_memory_equal(out, codes, sizeof(codes));
    }
}

static void the_table_has_the_known_depths(void **state)
{
    static const uint16_t known[][2] = {
        {300, 438},  {400, 501},  {500, 586},  {600, 706},   {700, 887},   {750, 1018}, {800, 1194},
        {850, 1443}, {900, 1824}, {950, 2478}, {1000, 3864}, {1023, 5203}, {1050, 8767}};
    uint16_t lut[DX_KINECT_N_CODES];

    (void)state;
    dx_kinect_lut_fill(lut, &usual, 11, 10000);
    for (size_t k = 0; k < sizeof(known) / sizeof(known[0]); k++)
        assert_int_equal(lut[known[k][0]], known[k][1]);
    /* No data; and behind the pole, where depths are negative. */
    assert_int_equal(lut[2047], 0);
    for (unsigned k = 1090; k < DX_KINECT_N_CODES; k++)
        assert_int_equal(lut[k], 0);
    for (unsigned k = 1; k < 1050; k++)
        assert_true(lut[k] >= lut[k - 1] && lut[k] <= 10000);
    /* The two approximations that went round before the constants were known. */
    for (unsigned k = 500; k <= 1000; k++) {
        assert_true(fabs(1000 / (3.3309495161 - 0.0030711016 * k) - lut[k]) < 0.05 * lut[k] + 1);
        assert_true(fabs(123.6 * tan(k / 2842.5 + 1.1863) - lut[k]) < 0.05 * lut[k] + 1);
    }
    dx_kinect_lut_fill(lut, &usual, 11, 2000);
    assert_int_equal(lut[900], 1824);
    assert_int_equal(lut[950], 0);
    dx_kinect_lut_fill(lut, &usual, 10, 10000);
    assert_int_equal(lut[1000], 3864);
    assert_int_equal(lut[1023], 0);
}

static void impossible_constants_are_refused(void **state)
{
    static const float bad[] = {0, -1, NAN, INFINITY, 1e-30f, 1e30f};

    (void)state;
    assert_null(dx_kinect_constants_wrong(&usual));
    for (size_t k = 0; k < sizeof(bad) / sizeof(bad[0]); k++) {
        struct dx_kinect_constants c = usual;

        c.emitter_cm = bad[k];
        assert_non_null(dx_kinect_constants_wrong(&c));
        c = usual;
        c.reference_mm = bad[k];
        assert_non_null(dx_kinect_constants_wrong(&c));
        c = usual;
        c.pixel_mm = bad[k];
        assert_non_null(dx_kinect_constants_wrong(&c));
    }
}

/* ---- blocks to frames
 * ---------------------------------------------------------------------------- */

struct sink {
    struct dx_geometry *g;
    struct dx_plane plane;
    unsigned n_geometries, n_frames;
    bool closing;
    struct dx_frame_part part;
};

static int sink_geometry(void *ctx, struct dx_geometry *g, uint8_t attr_bytes)
{
    struct sink *s = ctx;

    dx_geometry_ref(g);
    dx_geometry_unref(s->g);
    dx_plane_fini(&s->plane);
    s->g = g;
    s->n_geometries++;
    return dx_plane_init_for(&s->plane, g, attr_bytes);
}

static struct dx_plane *sink_plane(void *ctx, uint64_t number)
{
    struct sink *s = ctx;

    (void)number;
    dx_plane_clear(&s->plane);
    return s->closing ? NULL : &s->plane;
}

static void sink_deliver(void *ctx, const struct dx_frame_part *part)
{
    struct sink *s = ctx;

    s->part = *part;
    s->n_frames++;
}

struct rig {
    struct kinect_sim sim;
    struct dx_kinect_header h;
    struct dx_kinect_decoder decoder;
    struct sink s;
    struct dx_frame_sink sink;
    struct dx_block block;
    struct dx_err err;
    uint16_t codes[DX_KINECT_PIXELS];
    uint8_t bytes[DX_KINECT_HEADER_LEN + DX_KINECT_PIXELS / 8 * 11];
};

/* A block as the driver makes it, of `codes`. */
static void make_block(struct rig *rig)
{
    size_t len = dx_kinect_frame_len(rig->h.bits);

    rig->sim.registers[0x12] = rig->h.bits == 11 ? 3 : 2;
    kinect_sim_codes(&rig->sim, rig->codes);
    dx_kinect_header_put(rig->bytes, &rig->h);
    memcpy(rig->bytes + DX_KINECT_HEADER_LEN, rig->sim.packed, len);
    rig->block = (struct dx_block){.bytes = rig->bytes,
                                   .len = DX_KINECT_HEADER_LEN + len,
                                   .stamp = {5, 7, DX_CLOCK_DEVICE},
                                   .number = 3,
                                   .source = "usb:1-1"};
}

static struct rig *rig_new(const struct dx_kinect_config *config)
{
    struct rig *rig = calloc(1, sizeof(*rig));

    kinect_sim_init(&rig->sim);
    rig->h = (struct dx_kinect_header){.bits = 11, .constants = usual};
    rig->sink = (struct dx_frame_sink){&rig->s, sink_geometry, sink_plane, sink_deliver};
    for (uint32_t k = 0; k < DX_KINECT_PIXELS; k++)
        rig->codes[k] = (uint16_t)(400 + k * 2654435761u % 600);
    dx_kinect_decoder_init(&rig->decoder, config);
    make_block(rig);
    return rig;
}

static void rig_free(struct rig *rig)
{
    dx_geometry_unref(rig->s.g);
    dx_plane_fini(&rig->s.plane);
    dx_kinect_decoder_fini(&rig->decoder);
    free(rig);
}

static int decode(struct rig *rig)
{
    return dx_kinect_decode(&rig->decoder, &rig->block, &rig->sink, &rig->err);
}

static const struct dx_kinect_config config = {.bits = 11, .max_m = 10, .cx = -1, .cy = -1};

static void a_block_becomes_a_frame(void **state)
{
    struct rig *rig = rig_new(&config);
    uint16_t lut[DX_KINECT_N_CODES];
    double f = 120.0 / (2 * (double)0.1042f);
    float p[3];

    (void)state;
    dx_kinect_lut_fill(lut, &usual, 11, 10000);
    for (int bits = 11; bits >= 10; bits--) {
        rig->h.bits = bits;
        make_block(rig);
        assert_int_equal(decode(rig), 0);
        for (uint32_t k = 0; k < DX_KINECT_PIXELS; k++)
            assert_int_equal(dx_plane_range(&rig->s.plane, k), lut[rig->codes[k]]);
    }
    assert_int_equal(rig->s.n_geometries, 1);
    assert_int_equal(rig->s.n_frames, 2);
    assert_int_equal(rig->s.part.frame, 1);
    assert_int_equal(rig->s.part.n_cols, 640);
    assert_true(rig->s.part.last);
    assert_int_equal(rig->s.part.stamp.device_ns, 7);
    assert_int_equal(rig->s.g->model, DX_MODEL_PINHOLE);
    dx_geometry_point(rig->s.g, 10, 600, 2000, p);
    assert_true(fabs(p[0] - 2 * (600 - 319.5) / f) < 1e-5 &&
                fabs(p[1] - 2 * (10 - 239.5) / f) < 1e-5);
    assert_true(fabs(p[2] - 2.0) < 1e-6);
    rig->s.closing = true;
    assert_int_equal(decode(rig), DX_DRIVER_E_AGAIN);
    assert_int_equal(rig->s.n_frames, 2);
    rig_free(rig);
}

/* A pixel that has even one bit in a hole is none; all others are as they were. */
static void holes_are_no_returns(void **state)
{
    static const unsigned lost[] = {0, 7, 8, 130, 241};
    struct rig *rig = rig_new(&config);
    uint16_t lut[DX_KINECT_N_CODES];

    (void)state;
    dx_kinect_lut_fill(lut, &usual, 11, 10000);
    for (size_t k = 0; k < sizeof(lost) / sizeof(lost[0]); k++)
        rig->h.lost[lost[k] / 8] |= (uint8_t)(1u << lost[k] % 8);
    make_block(rig);
    for (size_t k = 0; k < sizeof(lost) / sizeof(lost[0]); k++)
        memset(rig->bytes + DX_KINECT_HEADER_LEN + lost[k] * 1748, 0xff,
               lost[k] < 241 ? 1748 : 1132);
    assert_int_equal(decode(rig), 0);
    for (size_t k = 0; k < DX_KINECT_PIXELS; k++) {
        size_t first = k * 11 / 8 / 1748, last = (k * 11 + 10) / 8 / 1748;
        bool hole =
            rig->h.lost[first / 8] >> first % 8 & 1 || rig->h.lost[last / 8] >> last % 8 & 1;

        assert_int_equal(dx_plane_range(&rig->s.plane, k), hole ? 0 : lut[rig->codes[k]]);
    }
    rig_free(rig);
}

static void another_device_is_another_geometry(void **state)
{
    struct rig *rig = rig_new(&config);
    struct dx_kinect_config own = config;
    uint16_t lut[DX_KINECT_N_CODES];

    (void)state;
    assert_int_equal(decode(rig), 0);
    rig->h.constants.shift = 201; /* other depths, the same rays */
    make_block(rig);
    assert_int_equal(decode(rig), 0);
    assert_int_equal(rig->s.n_geometries, 1);
    dx_kinect_lut_fill(lut, &rig->h.constants, 11, 10000);
    assert_int_equal(dx_plane_range(&rig->s.plane, 5), lut[rig->codes[5]]);
    rig->h.constants.pixel_mm = 0.105f;
    make_block(rig);
    assert_int_equal(decode(rig), 0);
    assert_int_equal(rig->s.n_geometries, 2);
    assert_int_equal(rig->s.part.frame, 2);
    rig_free(rig);

    own.fx = 594.2;
    own.cx = 339.5;
    rig = rig_new(&own);
    assert_int_equal(decode(rig), 0);
    assert_true(fabs(rig->s.g->table[0] - -339.5 / 594.2) < 1e-6);
    assert_true(fabs(rig->s.g->table[640] - -239.5 / 594.2) < 1e-6);
    rig->h.constants.pixel_mm = 0.105f; /* a calibration goes before */
    make_block(rig);
    assert_int_equal(decode(rig), 0);
    assert_int_equal(rig->s.n_geometries, 1);
    rig_free(rig);
}

static void hostile_blocks_are_corrupt(void **state)
{
    static const unsigned checked[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 15};
    struct rig *rig = rig_new(&config);
    size_t len = rig->block.len;

    (void)state;
    for (size_t n = 0; n < 4 * DX_KINECT_HEADER_LEN; n++) {
        rig->block.len = n;
        assert_int_equal(decode(rig), DX_DRIVER_E_CORRUPT);
        assert_non_null(strstr(rig->err.text, "usb:1-1: block 3: "));
    }
    for (int d = -1; d <= 1; d += 2) {
        rig->block.len = len + (size_t)d;
        assert_int_equal(decode(rig), DX_DRIVER_E_CORRUPT);
    }
    rig->block.len = len;
    for (size_t k = 0; k < sizeof(checked) / sizeof(checked[0]); k++)
        for (unsigned bit = 0; bit < 8; bit++) {
            rig->bytes[checked[k]] ^= (uint8_t)(1u << bit);
            assert_int_equal(decode(rig), DX_DRIVER_E_CORRUPT);
            rig->bytes[checked[k]] ^= (uint8_t)(1u << bit);
        }
    dx_put_u32(rig->bytes + 28, 0x7fc00000); /* NaN */
    assert_int_equal(decode(rig), DX_DRIVER_E_CORRUPT);
    assert_non_null(strstr(rig->err.text, "at byte 16: "));
    assert_int_equal(rig->s.n_geometries, 0);
    make_block(rig);
    memset(rig->bytes + 52, 0xff, 32); /* all lost, and packets that there are none of */
    assert_int_equal(decode(rig), 0);
    for (size_t k = 0; k < DX_KINECT_PIXELS; k++)
        assert_int_equal(dx_plane_range(&rig->s.plane, k), 0);
    rig_free(rig);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_known_bytes_unpack),
        cmocka_unit_test(all_codes_unpack),
        cmocka_unit_test(the_table_has_the_known_depths),
        cmocka_unit_test(impossible_constants_are_refused),
        cmocka_unit_test(a_block_becomes_a_frame),
        cmocka_unit_test(holes_are_no_returns),
        cmocka_unit_test(another_device_is_another_geometry),
        cmocka_unit_test(hostile_blocks_are_corrupt),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
