/* The PLY reader: what the writer writes comes back; bad files are told, none is trusted. */
#include "core/base/rng.h"
#include "tools/out_mesh.h"
#include "tools/ply_read.h"

#include <errno.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <cmocka.h>

static struct dx_mesh sample(uint8_t attr_bytes)
{
    struct dx_mesh m;
    static const float xyz[] = {0, 0, 1, 1, 0, 2, 0, 1, 3, 1, 1, 4};

    assert_int_equal(dx_mesh_init(&m, 4, 2, attr_bytes, 0), 0);
    memcpy(m.xyz, xyz, sizeof(xyz));
    memcpy(m.index, (uint32_t[]){0, 1, 3, 0, 3, 2}, 24);
    for (uint16_t k = 0; m.attr && k < 4; k++)
        m.attr[k] = (uint16_t)(50 * k);
    return m;
}

/* The bytes of the sample as PLY. */
static size_t written(char bytes[2048], uint8_t attr_bytes, struct dx_out_options o)
{
    struct dx_mesh m = sample(attr_bytes);
    FILE *f = fmemopen(bytes, 2048, "wb");
    size_t len;

    assert_non_null(f);
    dx_mesh_writer_ply.write(f, &m, &o);
    fflush(f);
    len = (size_t)ftell(f);
    fclose(f);
    dx_mesh_fini(&m);
    return len;
}

static void assert_same(const char *bytes, size_t len, uint8_t attr_bytes)
{
    struct dx_mesh m = sample(attr_bytes), back;
    struct dx_err err = {.text = ""};

    if (dx_ply_parse(&back, (const uint8_t *)bytes, len, &err) != 0)
        fail_msg("%s", err.text);
    assert_int_equal(back.n_vertices, 4);
    assert_int_equal(back.n_triangles, 2);
    assert_int_equal(back.attr_bytes, attr_bytes);
    assert_memory_equal(back.xyz, m.xyz, 48);
    assert_memory_equal(back.index, m.index, 24);
    if (attr_bytes)
        assert_memory_equal(back.attr, m.attr, 8);
    dx_mesh_fini(&m);
    dx_mesh_fini(&back);
}

static void test_comes_back(void **state)
{
    struct dx_out_options world = {.world = true, .pose = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    char bytes[2048];

    (void)state;
    for (uint8_t attr_bytes = 0; attr_bytes <= 2; attr_bytes++) {
        assert_same(bytes, written(bytes, attr_bytes, (struct dx_out_options){0}), attr_bytes);
        assert_same(bytes, written(bytes, attr_bytes, world), attr_bytes);
    }
}

static void refused(const char *bytes, size_t len, const char *text)
{
    struct dx_mesh m;
    struct dx_err err = {.text = ""};

    assert_true(dx_ply_parse(&m, (const uint8_t *)bytes, len, &err) < 0);
    assert_null(m.xyz);
    if (!strstr(err.text, text))
        fail_msg("found '%s', expected '%s' in it", err.text, text);
}

static void test_tells_what_is_wrong(void **state)
{
    char bytes[2048];
    size_t len = written(bytes, 0, (struct dx_out_options){0});
    char *p;

    (void)state;
    refused(bytes, len - 1, "found 73 bytes, expected 74 (4 vertices, 2 triangles)");
    refused(bytes, 20, "line 2: found no end of line");
    refused("", 0, "line 1: found no end of line");
    bytes[len - 13] = 4;
    refused(bytes, len, "face 1: found 4 vertices, expected 3");
    bytes[len - 13] = 3;
    bytes[len - 4] = 4;
    refused(bytes, len, "face 1: found vertex 4, expected less than 4");
    bytes[len - 4] = 2;
    memcpy(bytes + len - 26 - 4, "\0\0\xc0\x7f", 4);
    refused(bytes, len, "vertex 3: found a coordinate that is not finite");
    p = strstr(bytes, "vertex 4");
    p[7] = '9';
    refused(bytes, len, "expected 134 (9 vertices");
    len = written(bytes, 0, (struct dx_out_options){.ascii = true});
    refused(bytes, len, "line 2: found 'format ascii 1.0'");
}

/* Changed bytes must be read or refused, under the sanitizers without a word from them. */
static void test_survives_changed_bytes(void **state)
{
    struct dx_rng rng = dx_rng_init(7, 0);
    char good[2048], bytes[2048];
    size_t len = written(good, 2, (struct dx_out_options){0});

    (void)state;
    for (int round = 0; round < 20000; round++) {
        struct dx_mesh m;
        struct dx_err err;
        size_t n = dx_rng_below(&rng, 4) ? len : dx_rng_below(&rng, (uint32_t)len);
        uint8_t *exact = malloc(n + 1);

        memcpy(bytes, good, len);
        for (uint32_t k = dx_rng_below(&rng, 4); k-- > 0;)
            bytes[dx_rng_below(&rng, (uint32_t)len)] = (char)dx_rng_u64(&rng);
        assert_non_null(exact);
        memcpy(exact, bytes, n);
        dx_ply_parse(&m, exact, n, &err);
        dx_mesh_fini(&m);
        free(exact);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_comes_back),
        cmocka_unit_test(test_tells_what_is_wrong),
        cmocka_unit_test(test_survives_changed_bytes),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
