/* Command line values: what is taken, and what is refused with which words. */
#include "tools/args.h"

#include <errno.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>
#include <cmocka.h>

/* Standard error of the calls between begin and end. */
static char said[1024];
static int real_stderr;
static FILE *capture;

static void begin(void)
{
    fflush(stderr);
    real_stderr = dup(2);
    capture = tmpfile();
    assert_non_null(capture);
    assert_int_equal(dup2(fileno(capture), 2), 2);
}

static const char *end(void)
{
    size_t len;

    fflush(stderr);
    assert_int_equal(dup2(real_stderr, 2), 2);
    close(real_stderr);
    rewind(capture);
    len = fread(said, 1, sizeof(said) - 1, capture);
    said[len] = 0;
    fclose(capture);
    return said;
}

static int real(double *out, const char *text)
{
    return dx_arg_double(out, &(struct dx_arg){"dexel mesh", "--tilt", text}, 0, 89, "degrees");
}

static void test_double(void **state)
{
    static const char *const bad[] = {"",    "abc", "1x",   "1 ",   " 1",
                                      "nan", "inf", "0x10", "89.1", "-1"};
    double v;

    (void)state;
    assert_int_equal(real(&v, "78.69"), 0);
    assert_true(v == 78.69);
    assert_int_equal(real(&v, "1e1"), 0);
    assert_true(v == 10);
    for (size_t k = 0; k < sizeof(bad) / sizeof(bad[0]); k++) {
        begin();
        assert_int_equal(real(&v, bad[k]), -EINVAL);
        end();
    }
    begin();
    real(&v, "abc");
    assert_string_equal(end(), "dexel mesh: --tilt: found 'abc', expected degrees from 0 to 89\n");
}

static void test_u64(void **state)
{
    static const char *const bad[] = {"",    "-1", "+1",  "1.0",
                                      "12a", "0",  "101", "99999999999999999999"};
    uint64_t v;

    (void)state;
    assert_int_equal(dx_arg_u64(&v, &(struct dx_arg){"c", "-n", "100"}, 1, 100, "frames"), 0);
    assert_int_equal(v, 100);
    for (size_t k = 0; k < sizeof(bad) / sizeof(bad[0]); k++) {
        begin();
        assert_int_equal(dx_arg_u64(&v, &(struct dx_arg){"c", "-n", bad[k]}, 1, 100, "frames"),
                         -EINVAL);
        end();
    }
}

static void test_size(void **state)
{
    static const char *const bad[] = {"",       "10",      "x10",   "10x",  "10x0",
                                      "10x20x", "65536x1", "10X20", "-1x2", "1x+2"};
    uint32_t w, h;

    (void)state;
    assert_int_equal(dx_arg_size(&w, &h, &(struct dx_arg){"c", "--size", "1024x65535"}), 0);
    assert_int_equal(w, 1024);
    assert_int_equal(h, 65535);
    for (size_t k = 0; k < sizeof(bad) / sizeof(bad[0]); k++) {
        begin();
        assert_int_equal(dx_arg_size(&w, &h, &(struct dx_arg){"c", "--size", bad[k]}), -EINVAL);
        end();
    }
}

static void test_triple(void **state)
{
    static const char *const bad[] = {"", "1,", "1,,2", "1,2,3,4", "1;2", ",1", "1,-2"};
    double v[3];

    (void)state;
    assert_int_equal(dx_arg_triple(v, &(struct dx_arg){"c", "-s", "0.5,1e-3,2"}, 0, 10, "n"), 3);
    assert_true(v[0] == 0.5 && v[1] == 1e-3 && v[2] == 2);
    assert_int_equal(dx_arg_triple(v, &(struct dx_arg){"c", "-s", "4"}, 0, 10, "n"), 1);
    assert_true(v[0] == 4 && v[1] == 0 && v[2] == 0);
    for (size_t k = 0; k < sizeof(bad) / sizeof(bad[0]); k++) {
        begin();
        assert_int_equal(dx_arg_triple(v, &(struct dx_arg){"c", "-s", bad[k]}, 0, 10, "n"),
                         -EINVAL);
        end();
    }
}

static void test_choice(void **state)
{
    static const char *const list[] = {"f32", "q16", NULL};

    (void)state;
    assert_int_equal(dx_arg_choice(&(struct dx_arg){"c", "-e", "q16"}, list), 1);
    begin();
    assert_int_equal(dx_arg_choice(&(struct dx_arg){"c", "-e", "q1"}, list), -EINVAL);
    assert_string_equal(end(), "c: -e: found 'q1', expected f32|q16\n");
}

static void test_thin(void **state)
{
    static const char *const bad[] = {"1x10", "10x1", "60000x60000", "10"};
    struct dx_thin_options o = {0};

    (void)state;
    assert_int_equal(dx_thin_args_check(&o, "c", "--size"), 0);
    assert_int_equal(dx_arg_keep(&o.keep, &(struct dx_arg){"c", "--keep", "nearest"}), 0);
    assert_int_equal(o.keep, DX_KEEP_NEAREST);
    begin();
    assert_int_equal(dx_thin_args_check(&o, "c", "--size"), -EINVAL);
    assert_string_equal(end(), "c: --keep: found 'nearest' without --size, expected both\n");
    assert_int_equal(dx_thin_args_size(&o, &(struct dx_arg){"c", "--size", "1500x1000"}), 0);
    assert_int_equal(o.width, 1500);
    assert_int_equal(o.height, 1000);
    assert_int_equal(dx_thin_args_check(&o, "c", "--size"), 0);
    begin();
    for (size_t k = 0; k < sizeof(bad) / sizeof(bad[0]); k++)
        assert_int_equal(dx_thin_args_size(&o, &(struct dx_arg){"c", "--size", bad[k]}), -EINVAL);
    end();
    begin();
    assert_int_equal(dx_arg_keep(&o.keep, &(struct dx_arg){"c", "--keep", "best"}), -EINVAL);
    assert_string_equal(end(),
                        "c: --keep: found 'best', expected centre|nearest|median|mean|first\n");
}

static void test_terrain(void **state)
{
    struct dx_terrain_args a;

    (void)state;
    dx_terrain_args_default(&a);
    assert_int_equal(a.fit.seam, -1);
    assert_int_equal(dx_terrain_args_set(&a, "c", DX_OPTION_SIGMA, "0.01,0.001"), 0);
    assert_true(a.params.sigma_given && a.params.sigma[1] == 0.001);
    assert_int_equal(dx_terrain_args_set(&a, "c", DX_OPTION_SEAM, "on"), 0);
    assert_int_equal(a.fit.seam, 1);
    assert_int_equal(dx_terrain_args_set(&a, "c", DX_OPTION_SEAM, "off"), 0);
    assert_int_equal(a.fit.seam, 0);
    assert_int_equal(dx_terrain_args_set(&a, "c", DX_OPTION_DIAG, "fixed"), 0);
    assert_int_equal(a.params.diag, DX_DIAG_FIXED);
    assert_int_equal(dx_terrain_args_set(&a, "c", DX_OPTION_UNIT, "0.002"), 0);
    assert_true(a.fit.unit_m == 0.002);
    assert_int_equal(dx_terrain_args_check(&a, "c"), 0);
    assert_int_equal(dx_terrain_args_set(&a, "c", DX_OPTION_PAPER, NULL), 0);
    begin();
    assert_int_equal(dx_terrain_args_check(&a, "c"), -EINVAL);
    assert_string_equal(end(), "c: --paper needs --cap\n");
    assert_int_equal(dx_terrain_args_set(&a, "c", DX_OPTION_CAP, "0.5"), 0);
    assert_int_equal(dx_terrain_args_check(&a, "c"), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_double),  cmocka_unit_test(test_u64),    cmocka_unit_test(test_size),
        cmocka_unit_test(test_triple),  cmocka_unit_test(test_choice), cmocka_unit_test(test_thin),
        cmocka_unit_test(test_terrain),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
