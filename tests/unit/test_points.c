/* Unorganized points of files: all formats give the same points; damaged files are refused with
 * their place. */
#include "file_fixture.h"

#include "core/base/bytes.h"
#include "drivers/file/points.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>

static const double want[] = {1, -2, 3.5, 0.25, 1e6, -7, 8, 9, 10};

static struct dx_point_list list;

static int parse(const void *bytes, size_t len, const char *name, struct dx_err *err)
{
    uint8_t *exact = exact_copy(bytes, len); /* so that the sanitizer sees a read beyond */
    int rc = dx_point_list_parse(&list, exact, len, name, err);

    free(exact);
    return rc;
}

static void expect_points(const char *text, size_t len, const char *name)
{
    struct dx_err err = {""};

    if (parse(text, len, name, &err) < 0)
        fail_msg("%s: %s", name, err.text);
    assert_int_equal(list.n, 3);
    for (size_t k = 0; k < 9; k++)
        if (list.xyz[k] != want[k])
            fail_msg("%s: value %zu is %g, expected %g", name, k, list.xyz[k], want[k]);
}

static void reads_text(void **state)
{
    static const char *const cases[][2] = {
        {"a.xyz", "1 -2 3.5\n0.25 1e6 -7\n8 9 10"},
        {"a.xyz", "# made by hand\n\n  1 -2 3.5 128 0 0\n0.25 1e6 -7 1 2 3\r\n8 9 10 1 1 1\n"},
        {"a.txt", "x y z\n1 -2 3.5\n0.25 1e6 -7\n8 9 10\n"},
        {"a.csv", "\"X\",\"Y\",\"Z\"\n1,-2,3.5\n0.25, 1e6, -7\n8;9;10\n"},
        {"a.pts", "3\n1 -2 3.5 -300 9 9 9\n0.25 1000000 -7 0 9 9 9\n8 9 10 0 9 9 9\n"},
        {"a.pts", "# b\nd 0 0 0\ns 0 0 0\np 1 -2 3.5\np 0.25 1e6 -7\np 8 9 10\n"},
        {"a.m", "Vertex 1  1 -2 3.5 {rgb=(1 0 0)}\nVertex 2  0.25 1e6 -7\nVertex 5 8 9 10\n"
                "Face 1  1 2 5\n"},
        {"a.obj",
         "mtllib x\nv 1 -2 3.5\nvn 0 0 1\nv 0.25 1e6 -7 1 1 1\nv 8 9 10\nf 1//1 2//1 3//1\n"},
        {"a.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 1 -2 3.5\nvertex 0.25 1e6 -7\n"
                  "  vertex 8 9 10\nendloop\nendfacet\nendsolid x\n"},
        {"a.ply", "ply\nformat ascii 1.0\ncomment x\nelement vertex 3\nproperty float x\n"
                  "property double y\nproperty float z\nproperty uchar red\nelement face 1\n"
                  "property list uchar int vertex_indices\nend_header\n"
                  "1 -2 3.5 255\n0.25 1e6 -7 0\n8 9 10 0\n3 0 1 2\n"},
        {"a.ply", "ply\nformat ascii 1.0\nelement camera 2\nproperty list uchar int a\n"
                  "property float b\nelement vertex 3\nproperty float z\nproperty float x\n"
                  "property list int float w\nproperty float y\nend_header\n"
                  "2 7 7 0.5\n0 0.5\n3.5 1 0 -2\n-7 0.25 2 5 5 1e6\n10 8 1 1 9\n"},
        {"a.pcd", "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 3\n"
                  "HEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ascii\n"
                  "1 -2 3.5\n0.25 1e6 -7\n8 9 10\n"},
        {"a.ptx", "2\n2\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n1 2 3 1\n"
                  "0 -4 0.5 0.5\n0 0 0 0.5\n-0.75 999998 -10 0.5\n7 7 7 0.5\n"},
    };

    (void)state;
    for (size_t k = 0; k < sizeof(cases) / sizeof(cases[0]); k++)
        expect_points(cases[k][1], strlen(cases[k][1]), cases[k][0]);
}

/* Vertices of int8, float and double, behind a camera; `big` end first. */
static size_t binary_ply(uint8_t *out, bool big)
{
    const int len = sprintf((char *)out,
                            "ply\nformat binary_%s_endian 1.0\nelement camera 1\n"
                            "property list ushort short v\nelement vertex 3\nproperty float x\n"
                            "property double y\nproperty uchar c\nproperty float z\nend_header\n",
                            big ? "big" : "little");
    uint8_t *p = out + len;
    uint8_t record[64];

#define PUT(n_bytes)                                                                               \
    do {                                                                                           \
        for (size_t i = 0; i < (n_bytes); i++)                                                     \
            *p++ = record[big ? (n_bytes)-1 - i : i];                                              \
    } while (0)
    dx_put_u16(record, 2);
    PUT(2);
    for (int k = 0; k < 2; k++) {
        dx_put_u16(record, 0xfffe);
        PUT(2);
    }
    for (size_t k = 0; k < 3; k++) {
        dx_put_u32(record, dx_f32_bits((float)want[3 * k]));
        PUT(4);
        dx_put_u64(record, dx_f64_bits(want[3 * k + 1]));
        PUT(8);
        *p++ = 200;
        dx_put_u32(record, dx_f32_bits((float)want[3 * k + 2]));
        PUT(4);
    }
    return (size_t)(p - out);
}

static void reads_binary(void **state)
{
    uint8_t bytes[512] = {0};
    size_t len;

    (void)state;
    for (int big = 0; big < 2; big++) {
        len = binary_ply(bytes, big);
        expect_points((const char *)bytes, len, "a.ply");
        for (size_t cut = 1; cut < len; cut += 3) { /* every shorter one is refused */
            struct dx_err err;

            assert_int_equal(parse(bytes, len - cut, "a.ply", &err), -EBADMSG);
            assert_int_equal(list.n, 0);
        }
    }
    memset(bytes, 0, sizeof(bytes));
    dx_put_u32(bytes + 80, 1);
    for (size_t k = 0; k < 9; k++)
        dx_put_u32(bytes + 96 + 4 * k, dx_f32_bits((float)want[k]));
    expect_points((const char *)bytes, 134, "a.stl");
}

static void numbers_that_are_none_are_kept(void **state)
{
    struct dx_err err;
    const char text[] = "1 2 3\nnan nan nan\ninf 0 0\n";

    (void)state;
    assert_int_equal(parse(text, strlen(text), NULL, &err), 0);
    assert_int_equal(list.n, 3);
    assert_true(isnan(list.xyz[3]) && isinf(list.xyz[6]));
    assert_int_equal(parse("", 0, "a.xyz", &err), 0);
    assert_int_equal(list.n, 0);
}

static void errors_name_the_place(void **state)
{
    static const char *const cases[][3] = {
        {"a.xyz", "1 2 3\n4 5\n", "line 2: the line ends, expected x y z"},
        {"a.xyz", "1 2 3\n4 5 x7\n", "line 2: \"x7\", expected a number"},
        {"a.xyz", "1 2 3\nend\n", "line 2: \"end\", expected x y z"},
        {"a.xyz", "1 2 3\n\xff\xfe\n", "line 2: byte 0xff, expected a number"},
        {"a.obj", "v 1 2\n", "line 1: the line ends, expected x y z"},
        {"a.stl", "solid a\nvertex 1 2 three\n", "line 2: \"three\", expected vertex x y z"},
        {"a.stl", "solid a\nfacet normal 0 0 1\nhello\n",
         "line 3: \"hello\", expected facet, vertex"},
        {"a.stl", "solid a\nfacet\nvertex 1 2 3\nendfacet\n",
         "line 5: the file ends, expected endsolid"},
        {"a.pts", "3\n1 2 3\n4 5 6\n", "line 4: the file ends after 2 points, expected 3"},
        {"a.pts", "1\n1 2 3\n4 5 6\n", "line 3: \"4\", expected no more points than"},
        {"a.pts", "-1\n1 2 3\n", "line 1: \"-1\", expected x y z, or the number of points"},
        {"a.stl", "sold", "4 bytes, expected text that begins with \"solid\""},
        {"a.ply", "ply\nformat ascii 2\nelement vertex 1\nproperty float x\nend_header\n",
         "line 5: the header ends, expected a format and vertices with x, y and z"},
        {"a.ply", "ply\nformat text\n", "line 2: \"text\", expected ascii,"},
        {"a.ply", "ply\nproperty float x\n", "line 2: \"float\", expected an element"},
        {"a.ply", "ply\nelement vertex many\n", "line 2: \"many\", expected a number of elements"},
        {"a.ply", "ply\nformat ascii 1.0\nelement vertex 9\nproperty half x\n",
         "line 4: \"half\", expected a type"},
        {"a.ply",
         "ply\nformat ascii 1.0\nelement vertex 900000000\nproperty float x\n"
         "property float y\nproperty float z\nend_header\n1 2 3\n",
         "6 bytes are left, expected 5400000000"},
        {"a.pcd", "VERSION 0.7\nFIELDS x y\n", "line 3: the file ends"},
    };
    struct dx_err err;

    (void)state;
    for (size_t k = 0; k < sizeof(cases) / sizeof(cases[0]); k++) {
        assert_int_equal(parse(cases[k][1], strlen(cases[k][1]), cases[k][0], &err), -EBADMSG);
        if (!strstr(err.text, cases[k][2]))
            fail_msg("%s: \"%s\", expected \"%s\"", cases[k][1], err.text, cases[k][2]);
    }
    assert_int_equal(dx_point_list_read(&list, "/nonexistent.ply", &err), -ENOENT);
    assert_non_null(strstr(err.text, "/nonexistent.ply"));
    dx_point_list_fini(&list);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reads_text),
        cmocka_unit_test(reads_binary),
        cmocka_unit_test(numbers_that_are_none_are_kept),
        cmocka_unit_test(errors_name_the_place),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
