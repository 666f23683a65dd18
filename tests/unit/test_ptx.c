/* PTX: what a good file gives, and that every damaged one is refused with its line. */
#include "file_fixture.h"

#include <math.h>

#define IDENTITY_HEADER "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"
#define SMALL                                                                                      \
    "2\n3\n" IDENTITY_HEADER                                                                       \
    "1 2 3 0\n0 0 0 0.5\n4 5 6 0.25\n-7 8.5 9e-1 1\n1 1 1 0.5\n2 2 2 2e-1\n"

static int decode(struct dx_xyz_frame *f, const char *text, struct dx_err *err)
{
    size_t len = strlen(text);
    uint8_t *bytes = exact_copy(text, len);
    int rc = dx_format_ptx.decode(f, bytes, len, err);

    free(bytes);
    return rc;
}

static int64_t block_len(const char *text, struct dx_err *err)
{
    size_t len = strlen(text);
    uint8_t *bytes = exact_copy(text, len);
    int64_t n = dx_format_ptx.block_len(bytes, len, err);

    free(bytes);
    return n;
}

static void assert_point(const struct dx_xyz_frame *f, uint32_t row, uint32_t col, double x,
                         double y, double z)
{
    const double *p = f->xyz + 3 * ((size_t)row * f->width + col);

    assert_true(p[0] == x && p[1] == y && p[2] == z);
}

static void reads_columns_as_rows(void **state)
{
    struct dx_xyz_frame f = {0};
    struct dx_err err;

    (void)state;
    assert_int_equal(decode(&f, SMALL, &err), 0);
    assert_int_equal(f.width, 2);
    assert_int_equal(f.height, 3);
    assert_point(&f, 0, 0, 1, 2, 3);
    assert_true(isnan(f.xyz[3 * 2]) && isnan(f.xyz[3 * 2 + 2])); /* row 1, column 0 */
    assert_point(&f, 2, 0, 4, 5, 6);
    assert_point(&f, 0, 1, -7, 8.5, 0.9);
    assert_point(&f, 2, 1, 2, 2, 2);
    assert_int_equal(f.attr_bytes, 2);
    assert_int_equal(f.attr[0], 0);
    assert_int_equal(f.attr[1], 65535);
    assert_int_equal(f.attr[4], 16384);
    assert_int_equal(f.attr[5], 13107);
    dx_xyz_frame_fini(&f);
}

static void takes_colour_normals_and_line_ends(void **state)
{
    static const char *const rows[] = {"1 2 3",
                                       "1 2 3 10 20 30",
                                       "1 2 3 0.5 10 20 30",
                                       "1 2 3 .5 1 2 3 0 0 1",
                                       " 1\t2  3 0.5 ",
                                       "1 2 3 0.5 1 2 3 nan nan nan"};
    static const bool attr[] = {false, false, true, true, true, true};

    (void)state;
    for (int crlf = 0; crlf < 2; crlf++)
        for (size_t k = 0; k < sizeof(rows) / sizeof(rows[0]); k++) {
            const char *end = crlf ? "\r\n" : "\n";
            struct dx_xyz_frame f = {0};
            struct buffer b = {0};
            struct dx_err err;

            buffer_print(&b, "1%s2%s", end, end);
            for (const char *p = IDENTITY_HEADER; *p; p++)
                buffer_print(&b, *p == '\n' ? "%s" : "%.1s", *p == '\n' ? end : p);
            buffer_print(&b, "%s%s0 0 0%s%s%s", rows[k], end, end, end, end);
            assert_int_equal(decode(&f, (char *)b.bytes, &err), 0);
            assert_point(&f, 0, 0, 1, 2, 3);
            assert_true(isnan(f.xyz[3]));
            assert_int_equal(f.attr != NULL, attr[k]);
            dx_xyz_frame_fini(&f);
            buffer_fini(&b);
        }
}

/* world = [x y z 1] M: a quarter turn about z and a shift. */
static void turns_the_matrix(void **state)
{
    struct dx_xyz_frame f = {0};
    struct dx_err err;

    (void)state;
    assert_int_equal(decode(&f,
                            "1\n1\n5 6 7\n1 0 0\n0 1 0\n0 0 1\n"
                            "0 1 0 0\n-1 0 0 0\n0 0 1 0\n10 20 30 1\n1 2 3 0.5\n",
                            &err),
                     0);
    const double want[12] = {0, -1, 0, 10, 1, 0, 0, 20, 0, 0, 1, 30};

    for (int k = 0; k < 12; k++)
        assert_true(f.pose[k] == want[k]);
    dx_xyz_frame_fini(&f);
}

static void scales_intensity(void **state)
{
    static const struct {
        const char *first, *second;
        int want_first, want_second;
    } cases[] = {{"0", "1", 0, 65535},     {"0", "255", 0, 65535}, {"10", "255", 2570, 65535},
                 {"0", "65535", 0, 65535}, {"7", "300", 7, 300},   {"-2048", "2047", 0, 65535},
                 {"0", "1e9", 0, 65535},   {"nan", "1", 0, 65535}, {"-5", "-5", 0, 0}};

    (void)state;
    for (size_t k = 0; k < sizeof(cases) / sizeof(cases[0]); k++) {
        struct dx_xyz_frame f = {0};
        struct buffer b = {0};
        struct dx_err err;

        buffer_print(&b, "1\n2\n%s1 2 3 %s\n1 2 3 %s\n", IDENTITY_HEADER, cases[k].first,
                     cases[k].second);
        assert_int_equal(decode(&f, (char *)b.bytes, &err), 0);
        assert_int_equal(f.attr[0], cases[k].want_first);
        assert_int_equal(f.attr[1], cases[k].want_second);
        dx_xyz_frame_fini(&f);
        buffer_fini(&b);
    }
}

static void cuts_scans(void **state)
{
    struct buffer b = {0};
    struct dx_err err;

    (void)state;
    buffer_print(&b, "%s\n \r\n%s\n\n", SMALL, SMALL);
    assert_int_equal(block_len((char *)b.bytes, &err), strlen(SMALL));
    assert_int_equal(block_len((char *)b.bytes + strlen(SMALL), &err), strlen("\n \r\n" SMALL));
    assert_int_equal(block_len("\n\n", &err), 0);
    assert_int_equal(block_len("", &err), 0);
    assert_int_equal(block_len(" \t", &err), 0);
    buffer_fini(&b);
}

/* At every length: the whole decodes, what lacks only the last line end too, all else is refused by
 * line. */
static void refuses_every_truncation(void **state)
{
    const char *text = SMALL;
    size_t whole = strlen(text);

    (void)state;
    for (size_t len = 0; len <= whole; len++) {
        uint8_t *bytes = exact_copy(text, len);
        struct dx_xyz_frame f = {0};
        struct dx_err err = {""};
        int rc = dx_format_ptx.decode(&f, bytes, len, &err);
        int64_t n = dx_format_ptx.block_len(bytes, len, NULL);

        /* "2 2 2 2", "2 2 2" and the like are numbers as well */
        if (rc == 0)
            assert_true(len >= whole - 5 && n == (int64_t)len);
        else
            assert_true(strstr(err.text, "line ") != NULL && strstr(err.text, "expected") != NULL);
        dx_xyz_frame_fini(&f);
        free(bytes);
    }
}

static void refuses_damage(void **state)
{
    static const struct {
        const char *text, *message;
    } cases[] = {
        {"", "line 1: the file ends, expected a number of columns"},
        {"x\n", "line 1: \"x\", expected a number of columns"},
        {"0\n3\n", "line 1: \"0\", expected a number of columns, 1 to 65535"},
        {"-1\n3\n", "line 1: \"-1\", expected a number of columns"},
        {"2 3\n", "line 1: \"3\", expected the end of the line"},
        {"4294967297\n3\n", "line 1: \"4294967297\", expected a number of columns"},
        {"99999999999999999999999\n3\n", "line 1: "},
        {"2\n1.5\n", "line 2: \"1.5\", expected a number of rows"},
        {"1000000000\n1000000000\n" IDENTITY_HEADER "0 0 0\n", "line 1: \"1000000000\""},
        {"65535\n65535\n" IDENTITY_HEADER "0 0 0\n", "line 11: 6 bytes are left, expected 65535"},
        {"100\n100\n" IDENTITY_HEADER "0 0 0\n", "line 11: 6 bytes are left, expected 100 x 100"},
        {"1\n1\n0 0\n", "line 3: the line ends, expected 3 numbers"},
        {"1\n1\n0 0 0 0\n", "line 3: \"0\", expected the end of the line"},
        {"1\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 inf\n", "line 7: \"inf\", expected 4 numbers"},
        {"1\n2\n" IDENTITY_HEADER "1 2 3 4\n1 2 x 4\n", "line 12: \"x\", expected a number"},
        {"1\n2\n" IDENTITY_HEADER "1 2 3 4\n1 2 3,5 4\n", "line 12: \"3,5\", expected a number"},
        {"1\n2\n" IDENTITY_HEADER "1 2 3 4\n1 2      \n", "line 12: the line ends, expected x y z"},
        {"1\n2\n" IDENTITY_HEADER "1 2 3 4\n1 2 3 4 5 6 7\n", "line 12: 7 numbers, expected 4"},
        {"1\n2\n" IDENTITY_HEADER "1 2 3 4\n1 2 3 4 5 6 7 8 9 10 11\n",
         "line 12: \"11\", expected at most 10"},
        {"1\n2\n" IDENTITY_HEADER "1 2 3 4\n\n1 2 3 4\n", "line 12: the line ends"},
        {"1\n2\n" IDENTITY_HEADER "1 2 3 0.250000\n", "line 12: the file ends, expected x y z"},
        {"1\n1\n" IDENTITY_HEADER "1 2 \x01 0.250000\n", "line 11: byte 0x01, expected a number"},
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

/* Not numbers that a scanner measures: points without a return, and no trouble. */
static void takes_non_finite_points_as_missing(void **state)
{
    static const char *const points[] = {"nan nan nan 1", "inf 0 0 1", "1 1e999 2 0", "-0 0 0 1"};

    (void)state;
    for (size_t k = 0; k < sizeof(points) / sizeof(points[0]); k++) {
        struct dx_xyz_frame f = {0};
        struct buffer b = {0};
        struct dx_err err;

        buffer_print(&b, "1\n1\n%s%s\n", IDENTITY_HEADER, points[k]);
        assert_int_equal(decode(&f, (char *)b.bytes, &err), 0);
        assert_true(isnan(f.xyz[0]) && isnan(f.xyz[1]) && isnan(f.xyz[2]));
        dx_xyz_frame_fini(&f);
        buffer_fini(&b);
    }
}

static void knows_its_own(void **state)
{
    static const char pcd[] = "# .PCD v0.7\n";

    (void)state;
    assert_true(dx_format_ptx.probe((const uint8_t *)SMALL, strlen(SMALL)));
    assert_false(dx_format_ptx.probe((const uint8_t *)pcd, strlen(pcd)));
    assert_false(dx_format_ptx.probe((const uint8_t *)"1\n2\nply\n", 8));
    assert_false(dx_format_ptx.probe((const uint8_t *)"", 0));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reads_columns_as_rows),
        cmocka_unit_test(takes_colour_normals_and_line_ends),
        cmocka_unit_test(turns_the_matrix),
        cmocka_unit_test(scales_intensity),
        cmocka_unit_test(cuts_scans),
        cmocka_unit_test(refuses_every_truncation),
        cmocka_unit_test(refuses_damage),
        cmocka_unit_test(takes_non_finite_points_as_missing),
        cmocka_unit_test(knows_its_own),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
