/* Mesh files: all formats give the same triangles; damaged ones are refused with their place. */
#include "file_fixture.h"

#include "core/base/bytes.h"
#include "drivers/file/triangles.h"

#include <errno.h>
#include <math.h>

static struct dx_triangle_list triangles;
static struct dx_point_list points;

static int parse(const void *bytes, size_t len, const char *name, struct dx_err *err)
{
    uint8_t *exact = exact_copy(bytes, len); /* so that the sanitizer sees a read beyond */
    int rc = dx_triangle_list_parse(&triangles, &points, exact, len, name, err);

    free(exact);
    return rc;
}

/* A square of two triangles, by its first corner. */
static void expect_square(const void *bytes, size_t len, const char *name)
{
    static const double xyz[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    static const uint32_t index[] = {0, 1, 2, 0, 2, 3};
    struct dx_err err = {""};

    if (parse(bytes, len, name, &err) < 0)
        fail_msg("%s: %s", name, err.text);
    assert_int_equal(triangles.n, 2);
    assert_memory_equal(triangles.index, index, sizeof(index));
    assert_int_equal(points.n, 4);
    for (size_t k = 0; k < 12; k++)
        if (points.xyz[k] != xyz[k])
            fail_msg("%s: coordinate %zu is %g, expected %g", name, k, points.xyz[k], xyz[k]);
}

#define PLY_VERTICES "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"

static void reads_text(void **state)
{
    static const char *const cases[][2] = {
        {"a.ply", "ply\nformat ascii 1.0\n" PLY_VERTICES
                  "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
                  "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n"},
        {"a.ply", "ply\nformat ascii 1.0\n" PLY_VERTICES
                  "element edge 1\nproperty int a\nelement face 2\nproperty uchar red\n"
                  "property list uchar float texcoord\nproperty list int uint vertex_index\n"
                  "element face 1\nproperty int b\nend_header\n"
                  "0 0 0\n1 0 0\n1 1 0\n0 1 0\n7\n255 2 0.5 0.5 4 0 1 2 3\n0 0 2 0 1\n9\n"},
        {"a.obj", "v 0 0 0\nv 1 0 0\nvn 0 0 1\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1/1 3/2/1 4//1\n"},
        {"a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\n f -3 -2 -1\nv 0 1 0\nf -4 -2 -1\n"},
        {"a.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                  "vertex 1 1 0\nendloop\nendfacet\nfacet normal 0 0 1\nouter loop\n"
                  "vertex -0 0 0\nvertex 1 1 -0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n"},
    };

    (void)state;
    for (size_t k = 0; k < sizeof(cases) / sizeof(cases[0]); k++)
        expect_square(cases[k][1], strlen(cases[k][1]), cases[k][0]);
}

static size_t put_floats(uint8_t *out, const float *v, size_t n, bool big)
{
    for (size_t k = 0; k < n; k++) {
        const uint32_t bits = dx_f32_bits(v[k]);

        dx_put_u32(out + 4 * k, big ? __builtin_bswap32(bits) : bits);
    }
    return 4 * n;
}

static void reads_binary_ply(void **state)
{
    static const float xyz[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};

    (void)state;
    for (int big = 0; big < 2; big++) {
        uint8_t bytes[512];
        size_t len =
            (size_t)sprintf((char *)bytes,
                            "ply\nformat binary_%s_endian 1.0\n" PLY_VERTICES "element face 1\n"
                            "property list uchar ushort vertex_indices\nend_header\n",
                            big ? "big" : "little");

        len += put_floats(bytes + len, xyz, 12, big);
        bytes[len++] = 4;
        for (uint8_t v = 0; v < 4; v++) {
            bytes[len++] = big ? 0 : v;
            bytes[len++] = big ? v : 0;
        }
        expect_square(bytes, len, "a.ply");
        for (size_t cut = 1; cut < 10; cut++) {
            struct dx_err err = {""};

            assert_int_equal(parse(bytes, len - cut, "a.ply", &err), -EBADMSG);
            assert_int_equal(triangles.n, 0);
        }
    }
}

static void reads_binary_stl(void **state)
{
    static const float t[2][12] = {{0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 1, 0},
                                   {0, 0, 1, -0.0f, 0, 0, 1, 1, 0, 0, 1, 0}};
    uint8_t bytes[184] = {0};

    (void)state;
    dx_put_u32(bytes + 80, 2);
    for (size_t k = 0; k < 2; k++)
        put_floats(bytes + 84 + 50 * k, t[k], 12, false);
    expect_square(bytes, sizeof(bytes), "a.stl");
}

static void refuses(void **state)
{
    static const struct {
        const char *name, *text, *says;
    } cases[] = {
        {"a.xyz", "1 2 3\n", "PLY, OBJ or STL"},
        {"a.obj", "v 0 0 0\nf 1 1 2\n",
         "line 2: \"2\", expected a vertex's number, of those that there are"},
        {"a.obj", "f 1 2 3\n", "line 1: \"1\", expected a vertex's number"},
        {"a.obj", "v 0 0 0\nf 1 1\n", "line 2: the line ends, expected three corners"},
        {"a.obj", "v 0 0 0\nf 1 1 0\n", "line 2: "},
        {"a.obj", "v 0 0 0\nf 1 1 -2\n", "line 2: "},
        {"a.obj", "v 0 0 0\nf 1 1 1x", "line 2: "},
        {"a.obj", "v 0 0 0\nv nan 0 0\nf 1 1 2\n", "vertex 1: "},
        {"a.stl", "solid a\nvertex 0 0 0\nvertex 1 0 0\nendsolid\n", "2 vertices"},
        {"a.ply",
         "ply\nformat ascii 1.0\n" PLY_VERTICES
         "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
         "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 -2\n",
         "corner -2"},
    };

    (void)state;
    for (size_t k = 0; k < sizeof(cases) / sizeof(cases[0]); k++) {
        struct dx_err err = {""};

        assert_int_equal(parse(cases[k].text, strlen(cases[k].text), cases[k].name, &err),
                         -EBADMSG);
        if (!strstr(err.text, cases[k].says))
            fail_msg("'%s', expected '%s'", err.text, cases[k].says);
        assert_int_equal(triangles.n, 0);
        assert_int_equal(points.n, 0);
    }
}

static int forget(void **state)
{
    (void)state;
    dx_triangle_list_fini(&triangles);
    dx_point_list_fini(&points);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reads_text),
        cmocka_unit_test(reads_binary_ply),
        cmocka_unit_test(reads_binary_stl),
        cmocka_unit_test(refuses),
    };

    return cmocka_run_group_tests(tests, NULL, forget);
}
