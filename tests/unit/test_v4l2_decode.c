/* Blocks of depth cameras to ranges: every format, padded lines, what a code means, a lens, and
 * blocks that lie. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "core/base/bytes.h"
#include "core/base/rng.h"
#include "drivers/v4l2/v4l2_decode.h"
#include "drivers/v4l2/v4l2_rows.h"
#include "tests/unit/v4l2_fixture.h"

#include <linux/videodev2.h>

#include <math.h>

static struct dx_v4l2_header header(enum dx_v4l2_format format, uint32_t width, uint32_t height,
                                    uint32_t bytesperline)
{
    return (struct dx_v4l2_header){.shape = {.format = format,
                                             .width = width,
                                             .height = height,
                                             .bytesperline = bytesperline,
                                             .unit_m = 0.001}};
}

/* Decodes one image by a decoder of its own; the sink keeps what came. */
static void decode(struct v4l2_sink *s, const struct dx_v4l2_config *c,
                   const struct dx_v4l2_header *h, const void *image, size_t len)
{
    const struct dx_frame_sink sink = v4l2_sink_of(s);
    uint8_t *bytes = v4l2_bytes(h, image, len);
    const struct dx_block block = v4l2_block(bytes, len);
    struct dx_v4l2_decoder d;
    struct dx_err err = {""};

    dx_v4l2_decoder_init(&d, c);
    if (dx_v4l2_decode(&d, &block, &sink, &err))
        fail_msg("%s", err.text);
    dx_v4l2_decoder_fini(&d);
    free(bytes);
}

static void expect(const struct v4l2_sink *s, const uint16_t *want, size_t n)
{
    assert_int_equal(dx_plane_n_dexels(&s->plane), n);
    for (size_t k = 0; k < n; k++)
        if (dx_plane_range(&s->plane, k) != want[k])
            fail_msg("dexel %zu is %u, expected %u", k, dx_plane_range(&s->plane, k), want[k]);
}

static void expect_image(enum dx_v4l2_format format, uint32_t width, uint32_t height,
                         uint32_t bytesperline, const void *image, size_t len, const uint16_t *want)
{
    const struct dx_v4l2_header h = header(format, width, height, bytesperline);
    const struct dx_v4l2_config c = v4l2_config();
    struct v4l2_sink s = {0};

    decode(&s, &c, &h, image, len);
    expect(&s, want, (size_t)width * height);
    v4l2_sink_fini(&s);
}

static void test_formats(void **state)
{
    /* DEVICES 4.1: 3ff 001 200 155 in five bytes */
    static const uint8_t y10b[] = {0xff, 0xc0, 0x18, 0x01, 0x55};
    static const uint8_t le[] = {0x34, 0x12, 0xff, 0xff, 0x00, 0x00, 0x01, 0x80};
    /* infrared, which is not looked at, then depth */
    static const uint8_t inzi[] = {9, 9, 9, 9, 9, 9, 9, 9, 0x34, 0x12, 0xff, 0xff, 0, 0, 1, 0x80};

    (void)state;
    expect_image(DX_V4L2_Y10B, 4, 1, 5, y10b, 5, (const uint16_t[]){0x3ff, 1, 0x200, 0x155});
    expect_image(DX_V4L2_Z16, 4, 1, 8, le, 8, (const uint16_t[]){0x1234, 0xffff, 0, 0x8001});
    expect_image(DX_V4L2_Y16, 4, 1, 8, le, 8, (const uint16_t[]){0x1234, 0xffff, 0, 0x8001});
    expect_image(DX_V4L2_Y16_BE, 4, 1, 8, le, 8, (const uint16_t[]){0x3412, 0xffff, 0, 0x0180});
    expect_image(DX_V4L2_Y14, 4, 1, 8, le, 8, (const uint16_t[]){0x1234, 0x3fff, 0, 1});
    expect_image(DX_V4L2_Y12, 4, 1, 8, le, 8, (const uint16_t[]){0x234, 0xfff, 0, 1});
    expect_image(DX_V4L2_Y10, 4, 1, 8, le, 8, (const uint16_t[]){0x234, 0x3ff, 0, 1});
    expect_image(DX_V4L2_INZI, 2, 2, 4, inzi, 16, (const uint16_t[]){0x1234, 0xffff, 0, 0x8001});
    /* a driver that counts both images into a line */
    expect_image(DX_V4L2_INZI, 2, 2, 8, inzi, 16, (const uint16_t[]){0x1234, 0xffff, 0, 0x8001});
}

/* The names are the kernel's, and codes lead back to them. */
static void test_names(void **state)
{
    const struct {
        const char *name;
        uint32_t fourcc;
    } want[] = {
        {"Z16", V4L2_PIX_FMT_Z16},       {"INZI", V4L2_PIX_FMT_INZI},     {"Y16", V4L2_PIX_FMT_Y16},
        {"Y16_BE", V4L2_PIX_FMT_Y16_BE}, {"Y14", V4L2_PIX_FMT_Y14},       {"Y12", V4L2_PIX_FMT_Y12},
        {"Y10", V4L2_PIX_FMT_Y10},       {"Y10B", V4L2_PIX_FMT_Y10BPACK},
    };

    (void)state;
    for (size_t k = 0; k < 8; k++) {
        enum dx_v4l2_format f = dx_v4l2_format_find(want[k].fourcc);

        assert_string_equal(dx_v4l2_format_name(f), want[k].name);
        assert_int_equal(dx_v4l2_format_fourcc(f), want[k].fourcc);
    }
    assert_string_equal(dx_v4l2_format_name(0), "auto");
    assert_null(dx_v4l2_format_name(9));
    assert_int_equal(dx_v4l2_format_find(V4L2_PIX_FMT_YUYV), DX_V4L2_AUTO);
    assert_int_equal(dx_v4l2_format_find(0), DX_V4L2_AUTO);
}

/* Lines longer than their pixels; the last one may end early; bytes before the image. */
static void test_padding(void **state)
{
    static const uint8_t z16[] = {0xee, 0xee, 0xee, 1, 0, 2, 0, 0xee, 0xee, 3, 0, 4, 0};
    static const uint8_t y10b[] = {0xff, 0xc0, 0x18, 0x01, 0x55, 0xee, 0xee, 0, 0, 0, 0, 1};
    static const uint8_t inzi[] = {9, 9, 9, 9, 9, 9, 1, 0, 0xee, 3, 0};
    const struct dx_v4l2_config c = v4l2_config();
    struct dx_v4l2_header h = header(DX_V4L2_Z16, 2, 2, 6);
    struct v4l2_sink s = {0};

    (void)state;
    h.data_offset = 3;
    decode(&s, &c, &h, z16, sizeof(z16));
    expect(&s, (const uint16_t[]){1, 2, 3, 4}, 4);
    v4l2_sink_fini(&s);
    expect_image(DX_V4L2_Y10B, 4, 2, 7, y10b, 12,
                 (const uint16_t[]){0x3ff, 1, 0x200, 0x155, 0, 0, 0, 1});
    /* width 1, lines of 3 bytes (not 4, which counts both): depth begins at 6 */
    expect_image(DX_V4L2_INZI, 1, 2, 3, inzi, 11, (const uint16_t[]){1, 3});
}

static void test_limits(void **state)
{
    static const uint16_t codes[] = {0, 299, 300, 301, 4999, 5000, 5001, 6001, 6002, 65535};
    struct dx_v4l2_header h = header(DX_V4L2_Z16, 10, 1, 20);
    struct dx_v4l2_config c = v4l2_config();
    struct v4l2_sink s = {0};
    uint8_t image[20];

    (void)state;
    dx_put_u16s(image, codes, 10);
    c.min_m = 0.3; /* 299.99999999999994 units */
    c.max_m = 6.001;
    h.shape.invalid = 5000;
    decode(&s, &c, &h, image, 20);
    expect(&s, (const uint16_t[]){0, 0, 300, 301, 4999, 0, 5001, 6001, 0, 0}, 10);
    v4l2_sink_fini(&s);

    /* another unit: codes stay, limits move, and points are where they are */
    s = (struct v4l2_sink){0};
    h.shape.unit_m = 0.0001;
    c.min_m = 0.03;
    c.max_m = 0;
    decode(&s, &c, &h, image, 20);
    expect(&s, (const uint16_t[]){0, 0, 300, 301, 4999, 0, 5001, 6001, 6002, 65535}, 10);
    assert_true(s.g->unit_m == 0.0001f && s.g->model == DX_MODEL_PINHOLE);
    assert_true(s.part.last && s.part.col0 == 0 && s.part.n_cols == 10 && s.part.frame == 0);
    assert_true(s.part.stamp.host_ns == 7 && s.part.stamp.device_ns == 5);
    v4l2_sink_fini(&s);
}

/* The Kinect's, from the constants of DEVICES 2.5; values from there, 1 mm units. */
static void test_disparity(void **state)
{
    static const uint16_t codes[] = {300, 400, 500, 600, 700, 800, 900, 1000, 1022, 1023, 0, 1023};
    static const uint16_t want[] = {438, 501, 586, 706, 887, 1194, 1824, 3864, 0, 0, 317, 0};
    struct dx_v4l2_header h = header(DX_V4L2_Y10, 12, 1, 24);
    struct dx_v4l2_config c = v4l2_config();
    struct v4l2_sink s = {0};
    uint8_t image[24];

    (void)state;
    dx_put_u16s(image, codes, 12);
    c.max_m = 5;
    h.shape.k = 40 * 120 * 7.5 / 0.1042 / 1000;
    h.shape.d0 = 4 * 7.5 / 0.1042 + 4 * (200 + 0.375);
    h.shape.invalid = 1023;
    decode(&s, &c, &h, image, 24);
    expect(&s, want, 12);
    v4l2_sink_fini(&s);
}

/* Disparities that grow with nearness, as of two cameras; what is deeper than 16 bits hold. */
static void test_stereo(void **state)
{
    static const uint16_t codes[] = {0, 1, 30, 64, 6400};
    struct dx_v4l2_header h = header(DX_V4L2_Y16, 5, 1, 10);
    const struct dx_v4l2_config c = v4l2_config();
    struct dx_v4l2_decoder d;
    struct v4l2_sink s = {0};
    const struct dx_frame_sink sink = v4l2_sink_of(&s);
    struct dx_err err;
    uint8_t image[10], *bytes;

    (void)state;
    dx_put_u16s(image, codes, 5);
    h.shape.k = -640; /* 640 m / code */
    bytes = v4l2_bytes(&h, image, 10);
    dx_v4l2_decoder_init(&d, &c);
    assert_int_equal(dx_v4l2_decode(&d, &(struct dx_block){.bytes = bytes, .len = 74}, &sink, &err),
                     0);
    expect(&s, (const uint16_t[]){0, 0, 21333, 10000, 100}, 5);
    assert_int_equal(d.n_beyond, 1); /* 640 m */
    dx_v4l2_decoder_fini(&d);
    v4l2_sink_fini(&s);
    free(bytes);
}

/* A bent lens: the points are those of the rays at the depths that the camera told. */
static void test_lens(void **state)
{
    struct dx_v4l2_header h = header(DX_V4L2_Z16, 64, 48, 128);
    struct dx_v4l2_config c = v4l2_config();
    struct v4l2_sink s = {0};
    uint8_t image[64 * 48 * 2];

    (void)state;
    c.lens.fx = 40;
    c.lens.k1 = -0.1;
    c.lens.p1 = 0.001;
    for (unsigned k = 0; k < 64 * 48; k++)
        dx_put_u16(image + 2 * k, (uint16_t)(1000 + k));
    decode(&s, &c, &h, image, sizeof(image));
    assert_int_equal(s.g->model, DX_MODEL_TABLE);
    dx_lens_settle(&c.lens, 48, 64);
    for (uint32_t i = 0; i < 48; i++)
        for (uint32_t j = 0; j < 64; j++) {
            double z = (1000 + i * 64 + j) * 0.001, ray[2];
            float p[3];

            assert_int_equal(dx_lens_ray(&c.lens, i, j, ray), 0);
            dx_geometry_point(s.g, i, j, dx_plane_range(&s.plane, i * 64 + j), p);
            assert_true(fabs((double)p[0] - z * ray[0]) < 0.00051);
            assert_true(fabs((double)p[1] - z * ray[1]) < 0.00051);
            assert_true(fabs((double)p[2] - z) < 0.00051);
        }
    v4l2_sink_fini(&s);
}

/* Ranges of the corners grow out of 16 bits while the depths do not. */
static void test_beyond(void **state)
{
    static const float stretch[] = {1, 1.25f, 1.5f, 1};
    uint16_t row[] = {65535, 52428, 52428, 0};

    (void)state;
    assert_int_equal(dx_v4l2_row_stretch(row, stretch, 4), 1);
    assert_int_equal(row[0], 65535);
    assert_int_equal(row[1], 65535);
    assert_int_equal(row[2], 0);
    assert_int_equal(row[3], 0);
}

/* Loops over many against the same one at a time: no vector differs from its scalars. */
static void test_rows(void **state)
{
    enum { N = 1003 };
    struct dx_rng rng = dx_rng_init(4, 0);
    uint16_t codes[N], limited[N], stretched[N], looked[N];
    static float depth[65536], stretch[N];

    (void)state;
    for (unsigned k = 0; k < 65536; k++)
        depth[k] = (float)(dx_rng_unit(&rng) * 80000);
    for (unsigned k = 0; k < N; k++) {
        codes[k] = (uint16_t)dx_rng_u64(&rng);
        stretch[k] = (float)(1 + dx_rng_unit(&rng));
    }
    memcpy(limited, codes, sizeof(codes));
    memcpy(stretched, codes, sizeof(codes));
    memcpy(looked, codes, sizeof(codes));
    dx_v4l2_row_limit(limited, N, 300, 40000, codes[7]);
    dx_v4l2_row_stretch(stretched, stretch, N);
    dx_v4l2_row_lookup(looked, depth, stretch, N);
    for (unsigned k = 0; k < N; k++) {
        uint16_t one = codes[k];

        dx_v4l2_row_limit(&one, 1, 300, 40000, codes[7]);
        assert_int_equal(limited[k], one);
        one = codes[k];
        dx_v4l2_row_stretch(&one, stretch + k, 1);
        assert_int_equal(stretched[k], one);
        one = codes[k];
        dx_v4l2_row_lookup(&one, depth, stretch + k, 1);
        assert_int_equal(looked[k], one);
    }
}

/* Frames are counted over all blocks; the geometry is told again only when it is another. */
static void test_geometry_again(void **state)
{
    static const uint8_t image[64];
    const struct dx_v4l2_config c = v4l2_config();
    struct dx_v4l2_header h = header(DX_V4L2_Z16, 4, 2, 8);
    struct v4l2_sink s = {0};
    const struct dx_frame_sink sink = v4l2_sink_of(&s);
    struct dx_v4l2_decoder d;
    struct dx_err err;
    const struct {
        uint32_t width, height, bytesperline, invalid;
        double unit_m, k;
        unsigned n_geometries;
    } step[] = {
        {4, 2, 8, 0, 0.001, 0, 1},  {4, 2, 8, 0, 0.001, 0, 1},
        {4, 2, 12, 0, 0.001, 0, 1}, /* longer lines are no other geometry */
        {4, 2, 12, 9, 0.001, 0, 1}, {4, 2, 12, 9, 0.001, 2, 1},
        {4, 2, 12, 9, 0.002, 2, 2}, {2, 4, 8, 0, 0.002, 0, 3},
        {4, 2, 8, 0, 0.001, 0, 4},
    };

    (void)state;
    dx_v4l2_decoder_init(&d, &c);
    for (unsigned k = 0; k < 8; k++) {
        uint8_t *bytes;
        struct dx_block block;

        h.shape.width = step[k].width;
        h.shape.height = step[k].height;
        h.shape.bytesperline = step[k].bytesperline;
        h.shape.invalid = step[k].invalid;
        h.shape.unit_m = step[k].unit_m;
        h.shape.k = step[k].k;
        bytes = v4l2_bytes(&h, image, sizeof(image));
        block = v4l2_block(bytes, sizeof(image));
        assert_int_equal(dx_v4l2_decode(&d, &block, &sink, &err), 0);
        assert_int_equal(s.n_geometries, step[k].n_geometries);
        assert_int_equal(s.part.frame, k);
        assert_true(s.g->width == step[k].width && s.g->unit_m == (float)step[k].unit_m);
        free(bytes);
    }
    dx_v4l2_decoder_fini(&d);
    v4l2_sink_fini(&s);
}

static void test_closing(void **state)
{
    static const uint8_t image[16];
    const struct dx_v4l2_config c = v4l2_config();
    const struct dx_v4l2_header h = header(DX_V4L2_Z16, 4, 2, 8);
    struct v4l2_sink s = {.closing = true};
    const struct dx_frame_sink sink = v4l2_sink_of(&s);
    uint8_t *bytes = v4l2_bytes(&h, image, sizeof(image));
    const struct dx_block block = v4l2_block(bytes, sizeof(image));
    struct dx_v4l2_decoder d;
    struct dx_err err;

    (void)state;
    dx_v4l2_decoder_init(&d, &c);
    assert_int_equal(dx_v4l2_decode(&d, &block, &sink, &err), DX_DRIVER_E_AGAIN);
    assert_int_equal(s.n_frames, 0);
    dx_v4l2_decoder_fini(&d);
    v4l2_sink_fini(&s);
    free(bytes);
}

/* ---- blocks that lie --------------------------------------------------------------------------
 */

static void refuse(const uint8_t *bytes, size_t len, const struct dx_lens *lens, const char *text)
{
    struct dx_v4l2_config c = v4l2_config();
    struct v4l2_sink s = {0};
    const struct dx_frame_sink sink = v4l2_sink_of(&s);
    const struct dx_block block = {
        .bytes = bytes, .len = len, .number = 3, .source = "/dev/video9"};
    struct dx_v4l2_decoder d;
    struct dx_err err = {""};

    if (lens)
        c.lens = *lens;
    dx_v4l2_decoder_init(&d, &c);
    assert_int_equal(dx_v4l2_decode(&d, &block, &sink, &err), DX_DRIVER_E_CORRUPT);
    if (!strstr(err.text, text) || !strstr(err.text, "/dev/video9"))
        fail_msg("'%s' does not say '%s'", err.text, text);
    assert_int_equal(s.n_geometries + s.n_frames, 0);
    dx_v4l2_decoder_fini(&d);
}

/* A block cut anywhere is refused; copies of exactly that length let a sanitizer watch. */
static void test_cut(void **state)
{
    static const uint8_t image[24];
    const struct dx_v4l2_header h = header(DX_V4L2_Z16, 4, 3, 8);
    uint8_t *bytes = v4l2_bytes(&h, image, sizeof(image));

    (void)state;
    for (size_t len = 0; len < DX_V4L2_HEADER_LEN + sizeof(image); len++) {
        uint8_t *cut = malloc(len ? len : 1);

        memcpy(cut, bytes, len);
        refuse(cut, len, NULL, "block 3: length is ");
        free(cut);
    }
    free(bytes);
}

static void test_hostile(void **state)
{
    const struct {
        unsigned at, len;
        uint64_t value;
        const char *text;
    } lie[] = {
        {0, 4, 0x12345678, "byte 0: magic is 12345678"},
        {4, 2, 2, "byte 4: version 2 of 64 bytes"},
        {6, 2, 65, "byte 4: version 1 of 65 bytes"},
        {8, 4, V4L2_PIX_FMT_YUYV, "byte 8: pixel format 56595559"},
        {8, 4, 0, "byte 8: pixel format 00000000"},
        {12, 4, 0, "byte 12: image of 0x3"},
        {12, 4, 0xffffffff, "byte 12: image of 4294967295x3"},
        {16, 4, 0xffff, "length is 88, expected 524344"},
        {16, 4, 0, "byte 12: image of 4x0"},
        {20, 4, 7, "byte 12: line of 7 bytes, expected 8 or more"},
        {20, 4, 0xffffffff, "length is 88, expected 8589934662"},
        {24, 4, 1, "length is 88, expected 89"},
        {24, 4, 0xffffffff, "length is 88, expected 4294967383"},
        {40, 8, 0, "byte 40: unit 0 m"},
        {40, 8, 0x7ff8000000000000, "byte 40: unit nan m"},
        {40, 8, 0x4000000000000000, "byte 40: unit 2 m"},
        {48, 8, 0x7ff0000000000000, "disparity inf, 0"},
        {56, 8, 0xfff8000000000000, "byte 40"},
    };
    static const uint8_t image[24];
    const struct dx_v4l2_header h = header(DX_V4L2_Z16, 4, 3, 8);

    (void)state;
    for (size_t k = 0; k < sizeof(lie) / sizeof(lie[0]); k++) {
        uint8_t *bytes = v4l2_bytes(&h, image, sizeof(image)), value[8];

        dx_put_u64(value, lie[k].value);
        memcpy(bytes + lie[k].at, value, lie[k].len);
        refuse(bytes, DX_V4L2_HEADER_LEN + sizeof(image), NULL, lie[k].text);
        free(bytes);
    }
}

static void test_hostile_shapes(void **state)
{
    static const uint8_t image[200];
    const struct dx_lens folds = {.fx = 1, .cx = 0, .cy = 0, .k1 = -1};
    struct dx_v4l2_header h = header(DX_V4L2_Y10B, 6, 1, 8);
    uint8_t *bytes = v4l2_bytes(&h, image, sizeof(image));

    (void)state;
    refuse(bytes, DX_V4L2_HEADER_LEN + 8, NULL, "Y10B image 6 wide, expected a multiple of 4");
    h = header(DX_V4L2_INZI, 4, 3, 8);
    dx_v4l2_header_put(bytes, &h);
    refuse(bytes, DX_V4L2_HEADER_LEN + 47, NULL, "length is 111, expected 112 for INZI of 4x3");
    h = header(DX_V4L2_Z16, 4, 3, 8);
    dx_v4l2_header_put(bytes, &h);
    refuse(bytes, DX_V4L2_HEADER_LEN + 24, &folds, "the lens folds the image");
    free(bytes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_formats),   cmocka_unit_test(test_names),
        cmocka_unit_test(test_padding),   cmocka_unit_test(test_limits),
        cmocka_unit_test(test_disparity), cmocka_unit_test(test_stereo),
        cmocka_unit_test(test_lens),      cmocka_unit_test(test_beyond),
        cmocka_unit_test(test_rows),      cmocka_unit_test(test_geometry_again),
        cmocka_unit_test(test_closing),   cmocka_unit_test(test_cut),
        cmocka_unit_test(test_hostile),   cmocka_unit_test(test_hostile_shapes),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
