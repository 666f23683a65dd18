/* PCD: the three data forms give the same points; every damaged file is refused with its place. */
#include "file_fixture.h"

#include "core/base/bytes.h"

#include <liblzf/lzf.h>
#include <math.h>

#define SIZE_2X2 "WIDTH 2\nHEIGHT 2\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 4\n"
#define XYZ      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
#define ASCII    "# .PCD v0.7\n" XYZ SIZE_2X2 "DATA ascii\n1 2 3\nnan nan nan\n0 0 0\n-4 5e-1 6\n"

static int decode_bytes(struct dx_xyz_frame *f, const void *data, size_t len, struct dx_err *err)
{
    uint8_t *bytes = exact_copy(data, len);
    int rc = dx_format_pcd.decode(f, bytes, len, err);

    free(bytes);
    return rc;
}

static int decode(struct dx_xyz_frame *f, const char *text, struct dx_err *err)
{
    return decode_bytes(f, text, strlen(text), err);
}

static void assert_point(const struct dx_xyz_frame *f, size_t k, double x, double y, double z)
{
    const double *p = f->xyz + 3 * k;

    if (!(p[0] == x && p[1] == y && p[2] == z))
        fail_msg("point %zu: %g %g %g, expected %g %g %g", k, p[0], p[1], p[2], x, y, z);
}

static void assert_missing(const struct dx_xyz_frame *f, size_t k)
{
    assert_true(isnan(f->xyz[3 * k]) && isnan(f->xyz[3 * k + 1]) && isnan(f->xyz[3 * k + 2]));
}

static void reads_ascii(void **state)
{
    struct dx_xyz_frame f = {0};
    struct dx_err err;

    (void)state;
    assert_int_equal(decode(&f, ASCII, &err), 0);
    assert_int_equal(f.width, 2);
    assert_int_equal(f.height, 2);
    assert_point(&f, 0, 1, 2, 3);
    assert_missing(&f, 1);
    assert_missing(&f, 2);
    assert_point(&f, 3, -4, 0.5, 6);
    assert_null(f.attr);
    dx_xyz_frame_fini(&f);
}

/* Line ends of other systems, blank lines and comments between, no COUNT, no VIEWPOINT, an old
 * version. */
static void reads_other_headers(void **state)
{
    static const char *const texts[] = {
        "VERSION .7\r\nFIELDS x y z\r\nSIZE 4 4 4\r\nTYPE F F F\r\nWIDTH 1\r\nHEIGHT 2\r\nPOINTS "
        "2\r\n"
        "DATA ascii\r\n1 2 3\r\n4 5 6\r\n\r\n",
        "# .PCD v.5\n\n# by hand\nFIELDS z _ y x\nSIZE 4 4 4 8\nTYPE F U F F\nCOUNT 1 2 1 "
        "1\nHEIGHT 2\n"
        "WIDTH 1\nPOINTS 2\nDATA ascii\n3 9 9 2 1\n6 9 9 5 4",
    };

    (void)state;
    for (int k = 0; k < 2; k++) {
        struct dx_xyz_frame f = {0};
        struct dx_err err = {""};

        if (decode(&f, texts[k], &err))
            fail_msg("%s", err.text);
        assert_point(&f, 0, 1, 2, 3);
        assert_point(&f, 1, 4, 5, 6);
        dx_xyz_frame_fini(&f);
    }
}

/* A point as it is packed: padding, z, a 3-vector, x as f64, intensity u8, y as i16, colour. */
#define PACKED_HEADER                                                                              \
    "# .PCD v0.7\nVERSION 0.7\nFIELDS _ z normal x intensity y rgb\nSIZE 1 4 4 8 1 2 4\n"          \
    "TYPE U F F F U I F\nCOUNT 3 1 3 1 1 1 1\n" SIZE_2X2
enum { PACKED = 3 + 4 + 12 + 8 + 1 + 2 + 4 };

static void put_packed(uint8_t *p, double x, int16_t y, float z, uint8_t intensity)
{
    memset(p, 0xee, PACKED);
    dx_put_u32(p + 3, dx_f32_bits(z));
    dx_put_u64(p + 19, dx_f64_bits(x));
    p[27] = intensity;
    dx_put_u16(p + 28, (uint16_t)y);
}

static void put_points(uint8_t *p)
{
    put_packed(p, 1.25, -2, 3.5f, 0);
    put_packed(p + PACKED, (double)NAN, 0, 0, 7);
    put_packed(p + 2 * PACKED, 0, 0, 0, 9);
    put_packed(p + 3 * PACKED, 1e-3, 32767, -8, 255);
}

static void assert_packed_points(const struct dx_xyz_frame *f)
{
    assert_point(f, 0, 1.25, -2, 3.5);
    assert_missing(f, 1);
    assert_missing(f, 2);
    assert_point(f, 3, 1e-3, 32767, -8);
    assert_int_equal(f->attr_bytes, 2);
    assert_int_equal(f->attr[0], 0);
    assert_int_equal(f->attr[1], 7 * 257);
    assert_int_equal(f->attr[3], 65535);
}

static struct buffer binary_file(void)
{
    uint8_t points[4 * PACKED];
    struct buffer b = {0};

    put_points(points);
    buffer_print(&b, "%sDATA binary\n", PACKED_HEADER);
    buffer_add(&b, points, sizeof(points));
    return b;
}

/* The same fields as arrays, compressed. */
static struct buffer compressed_file(void)
{
    static const uint8_t sizes[] = {3, 4, 12, 8, 1, 2, 4};
    uint8_t points[4 * PACKED], arrays[4 * PACKED], packed[8 + 8 * PACKED], *out = arrays;
    struct buffer b = {0};
    uint32_t len;

    put_points(points);
    for (size_t k = 0, offset = 0; k < sizeof(sizes); offset += sizes[k++])
        for (size_t n = 0; n < 4; n++, out += sizes[k])
            memcpy(out, points + n * PACKED + offset, sizes[k]);
    len = lzf_compress(arrays, sizeof(arrays), packed + 8, sizeof(packed) - 8);
    assert_true(len > 0);
    dx_put_u32(packed, len);
    dx_put_u32(packed + 4, sizeof(arrays));
    buffer_print(&b, "%sDATA binary_compressed\n", PACKED_HEADER);
    buffer_add(&b, packed, 8 + len);
    return b;
}

static void reads_binary_and_compressed(void **state)
{
    struct buffer files[2] = {binary_file(), compressed_file()};

    (void)state;
    for (int k = 0; k < 2; k++) {
        struct dx_xyz_frame f = {0};
        struct dx_err err = {""};

        if (decode_bytes(&f, files[k].bytes, files[k].len, &err))
            fail_msg("%s", err.text);
        assert_packed_points(&f);
        dx_xyz_frame_fini(&f);
        buffer_fini(&files[k]);
    }
}

static void reads_every_type(void **state)
{
    static const struct {
        char type;
        int size;
        uint64_t bits;
        double value;
    } cases[] = {{'I', 1, 0xff, -1},
                 {'I', 2, 0x8000, -32768},
                 {'I', 4, 0xfffffffe, -2},
                 {'I', 8, 0xfffffffffffffffdu, -3},
                 {'U', 1, 0xff, 255},
                 {'U', 2, 0x8000, 32768},
                 {'U', 4, 0xfffffffe, 4294967294.0},
                 {'U', 8, 0x8000000000000000u, 9223372036854775808.0},
                 {'F', 4, 0x3fc00000, 1.5},
                 {'F', 8, 0xc004000000000000u, -2.5}};

    (void)state;
    for (size_t k = 0; k < sizeof(cases) / sizeof(cases[0]); k++) {
        struct dx_xyz_frame f = {0};
        struct buffer b = {0};
        struct dx_err err = {""};
        uint8_t bits[8];
        int s = cases[k].size;

        buffer_print(&b,
                     "FIELDS x y z\nSIZE %d %d %d\nTYPE %c %c %c\nWIDTH 1\nHEIGHT 2\nPOINTS 2\n"
                     "DATA binary\n",
                     s, s, s, cases[k].type, cases[k].type, cases[k].type);
        dx_put_u64(bits, cases[k].bits);
        for (int n = 0; n < 6; n++)
            buffer_add(&b, bits, (size_t)s);
        if (decode_bytes(&f, b.bytes, b.len, &err))
            fail_msg("%s", err.text);
        assert_point(&f, 1, cases[k].value, cases[k].value, cases[k].value);
        dx_xyz_frame_fini(&f);
        buffer_fini(&b);
    }
}

/* Colour as float bits and as an integer, in binary and in text: 8 bits of luminance. */
static void makes_luminance_of_colour(void **state)
{
    static const char *const texts[] = {
        "FIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nWIDTH 1\nHEIGHT 2\nPOINTS 2\nDATA ascii\n"
        "1 1 1 2.3418052e-38\n1 1 1 0\n", /* bits 0x00ff0000 */
        "FIELDS x y z rgba\nSIZE 4 4 4 4\nTYPE F F F U\nWIDTH 1\nHEIGHT 2\nPOINTS 2\nDATA ascii\n"
        "1 1 1 4294901760\n1 1 1 0\n",
        "FIELDS rgba x y z\nSIZE 4 4 4 4\nTYPE I F F F\nWIDTH 1\nHEIGHT 2\nPOINTS 2\nDATA ascii\n"
        "-65536 1 1 1\n0 1 1 1\n"};
    struct dx_xyz_frame f = {0};
    struct dx_err err;

    (void)state;
    for (int k = 0; k < 3; k++) {
        assert_int_equal(decode(&f, texts[k], &err), 0);
        assert_int_equal(f.attr_bytes, 1);
        assert_int_equal(f.attr[0], 76);
        assert_int_equal(f.attr[1], 0);
    }
    dx_xyz_frame_fini(&f);
}

static void turns_the_viewpoint(void **state)
{
    static const struct {
        const char *viewpoint;
        double pose[12];
    } cases[] = {
        {"1 2 3 1 0 0 0", {1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3}},
        {"0 0 0 0 1 0 0", {1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0}},
        {"0 0 0 0 0 0 0", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}},
        {"0 0 0 7 0 0 7", {0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0}},
        {"0 0 0 1e-90 0 0 1e-90", {0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0}},
    };

    (void)state;
    for (size_t k = 0; k < sizeof(cases) / sizeof(cases[0]); k++) {
        struct dx_xyz_frame f = {0};
        struct buffer b = {0};
        struct dx_err err;

        buffer_print(&b, "%sWIDTH 1\nHEIGHT 2\nVIEWPOINT %s\nPOINTS 2\nDATA ascii\n1 1 1\n1 1 1\n",
                     XYZ, cases[k].viewpoint);
        assert_int_equal(decode(&f, (char *)b.bytes, &err), 0);
        for (int i = 0; i < 12; i++)
            assert_true(fabs(f.pose[i] - cases[k].pose[i]) < 1e-12);
        dx_xyz_frame_fini(&f);
        buffer_fini(&b);
    }
}

/* At every length of each form: only what lacks nothing decodes; all else names a line or byte. */
static void refuses_every_truncation(void **state)
{
    struct buffer files[3] = {binary_file(), compressed_file(), {0}};

    (void)state;
    buffer_print(&files[2], "%s", ASCII);
    for (int k = 0; k < 3; k++) {
        for (size_t len = 0; len < files[k].len; len++) {
            struct dx_xyz_frame f = {0};
            struct dx_err err = {""};
            int rc = decode_bytes(&f, files[k].bytes, len, &err);

            if (k == 2 && len == files[k].len - 1) /* the last line end */
                assert_int_equal(rc, 0);
            else if (rc == 0 || (!strstr(err.text, "line ") && !strstr(err.text, "byte ")) ||
                     !strstr(err.text, "expected"))
                fail_msg("form %d, %zu bytes: %d \"%s\"", k, len, rc, err.text);
            dx_xyz_frame_fini(&f);
        }
        buffer_fini(&files[k]);
    }
}

/* Any byte of the compressed form changed: decodes or is refused, but stays within its memory. */
static void stands_every_flipped_byte(void **state)
{
    struct buffer file = compressed_file();

    (void)state;
    for (size_t k = 0; k < file.len; k++)
        for (int bit = 0; bit < 8; bit++) {
            struct dx_xyz_frame f = {0};
            struct dx_err err = {""};

            file.bytes[k] ^= (uint8_t)(1 << bit);
            if (decode_bytes(&f, file.bytes, file.len, &err))
                assert_true(err.text[0] != 0);
            file.bytes[k] ^= (uint8_t)(1 << bit);
            dx_xyz_frame_fini(&f);
        }
    buffer_fini(&file);
}

static void refuses_damage(void **state)
{
    static const struct {
        const char *text, *message;
    } cases[] = {
        {"", "line 1: the file ends, expected a keyword"},
        {"ply\n", "line 1: \"ply\", expected a keyword of the PCD header"},
        {"# .PCD\nFIELDS\n", "line 2: the line ends, expected names of fields"},
        {"SIZE 4\n", "line 1: \"SIZE\", expected FIELDS"},
        {"FIELDS x y z\nFIELDS x y z\n", "line 2: \"FIELDS\", expected each keyword once"},
        {"FIELDS x\nSIZE 3\n", "line 2: \"3\", expected a size of 1, 2, 4 or 8"},
        {"FIELDS x y\nSIZE 4\n", "line 2: the line ends, expected a size"},
        {"FIELDS x\nSIZE 4 4\n", "line 2: \"4\", expected the end of the line"},
        {"FIELDS x\nTYPE D\n", "line 2: \"D\", expected a type I, U or F"},
        {"FIELDS x\nCOUNT 0\n", "line 2: \"0\", expected a count of 1 to 65536"},
        {"FIELDS x\nCOUNT 4294967297\n", "line 2: \"4294967297\", expected a count"},
        {"WIDTH 4294967295\n", "line 1: \"4294967295\", expected a width of 1 to 65535"},
        {"HEIGHT 1e9\n", "line 1: \"1e9\", expected a height"},
        {"VIEWPOINT 0 0 0 1 0 0\n", "line 1: the line ends, expected 7 numbers"},
        {"VIEWPOINT 0 0 inf 1 0 0 0\n", "line 1: \"inf\", expected a finite number"},
        {XYZ "WIDTH 4\nPOINTS 4\nDATA ascii\n", "line 8: \"DATA\", expected HEIGHT"},
        {XYZ "WIDTH 4\nHEIGHT 1\nPOINTS 4\nDATA ascii\n1 1 1\n",
         "line 9: HEIGHT 1, an unorganized"},
        {XYZ "WIDTH 2\nHEIGHT 2\nPOINTS 5\nDATA ascii\n1 1 1\n", "line 9: POINTS 5, expected"},
        {XYZ "WIDTH 65535\nHEIGHT 65535\nPOINTS 4294836225\nDATA ascii\n",
         "line 8: \"4294836225\""},
        {XYZ "WIDTH 16384\nHEIGHT 16384\nPOINTS 268435456\nDATA ascii\n1 1 1\n", "byte "},
        {XYZ "WIDTH 16384\nHEIGHT 16384\nPOINTS 268435456\nDATA binary\n1 1 1\n", "byte "},
        {XYZ SIZE_2X2 "DATA text\n", "line 10: \"text\", expected ascii, binary or"},
        {"FIELDS x y\nSIZE 4 4\nTYPE F F\n" SIZE_2X2 "DATA ascii\n", "FIELDS without x, y or z"},
        {"FIELDS x y z\nSIZE 2 4 4\nTYPE F F F\n" SIZE_2X2 "DATA ascii\n",
         "line 8: field x of type F"},
        {"FIELDS x y z a\nSIZE 4 4 4 8\nTYPE F F F F\nCOUNT 1 1 1 65536\nWIDTH 2\nHEIGHT 2\nPOINTS "
         "4\n"
         "DATA binary\n1",
         "byte "},
        {"FIELDS x y z a b c\nSIZE 8 8 8 8 8 8\nTYPE F F F F F F\nCOUNT 1 1 1 65536 65536 "
         "65536\n" SIZE_2X2 "DATA binary\n",
         "line 9: 1048600 bytes a point"},
        {XYZ SIZE_2X2 "DATA ascii\n1 2 3\n1 2 3\n1 x 3      \n1 2 3\n",
         "line 13: \"x\", expected a number"},
        {XYZ SIZE_2X2 "DATA ascii\n1 2 3\n1 2 3\n1 2\n1 2 3     \n",
         "line 13: the line ends, expected a num"},
        {XYZ SIZE_2X2 "DATA ascii\n1 2 3\n1 2 3 4\n1 2 3\n1 2 3\n",
         "line 12: \"4\", expected the end of the"},
        {XYZ SIZE_2X2 "DATA ascii\n1 2 3\n1 2 3\n1 2 3\n1 2 3\n1 2 3\n",
         "line 15: \"1\", expected the end of"},
        {XYZ SIZE_2X2 "DATA binary_compressed\n1234", "byte "},
    };

    (void)state;
    for (size_t k = 0; k < sizeof(cases) / sizeof(cases[0]); k++) {
        struct dx_xyz_frame f = {0};
        struct dx_err err = {""};

        assert_true(decode(&f, cases[k].text, &err) < 0);
        if (strncmp(err.text, cases[k].message, strlen(cases[k].message)) != 0)
            fail_msg("case %zu: \"%s\", expected \"%s...\"", k, err.text, cases[k].message);
        dx_xyz_frame_fini(&f);
    }
}

/* Compressed data whose stated sizes cannot be: nothing of that size is allocated. */
static void refuses_absurd_compressed_sizes(void **state)
{
    static const uint32_t sizes[][2] = {{0xffffffff, 48}, {8, 0xffffffff}, {8, 47},
                                        {8, 49},          {0, 48},         {8, 48}};

    (void)state;
    for (size_t k = 0; k < sizeof(sizes) / sizeof(sizes[0]); k++) {
        struct dx_xyz_frame f = {0};
        struct buffer b = {0};
        struct dx_err err = {""};
        uint8_t data[16];

        memset(data, 0xff, sizeof(data)); /* a match before the start */
        dx_put_u32(data, sizes[k][0]);
        dx_put_u32(data + 4, sizes[k][1]);
        buffer_print(&b, "%s%sDATA binary_compressed\n", XYZ, SIZE_2X2);
        buffer_add(&b, data, sizeof(data));
        assert_true(decode_bytes(&f, b.bytes, b.len, &err) < 0);
        assert_memory_equal(err.text, "byte ", 5);
        assert_true(f.cap_dexels <= 4);
        dx_xyz_frame_fini(&f);
        buffer_fini(&b);
    }
}

static void is_one_block(void **state)
{
    struct dx_err err = {""};

    (void)state;
    assert_int_equal(dx_format_pcd.block_len((const uint8_t *)ASCII, strlen(ASCII), &err),
                     strlen(ASCII));
    assert_int_equal(dx_format_pcd.block_len((const uint8_t *)" \n", 2, &err), 0);
    assert_true(dx_format_pcd.block_len((const uint8_t *)ASCII, 40, &err) < 0);
    assert_true(dx_format_pcd.probe((const uint8_t *)ASCII, strlen(ASCII)));
    assert_false(dx_format_pcd.probe((const uint8_t *)"2\n3\n", 4));
    assert_false(dx_format_pcd.probe((const uint8_t *)"", 0));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reads_ascii),
        cmocka_unit_test(reads_other_headers),
        cmocka_unit_test(reads_binary_and_compressed),
        cmocka_unit_test(reads_every_type),
        cmocka_unit_test(makes_luminance_of_colour),
        cmocka_unit_test(turns_the_viewpoint),
        cmocka_unit_test(refuses_every_truncation),
        cmocka_unit_test(stands_every_flipped_byte),
        cmocka_unit_test(refuses_damage),
        cmocka_unit_test(refuses_absurd_compressed_sizes),
        cmocka_unit_test(is_one_block),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
