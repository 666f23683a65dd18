/* The keys of the V4L2 driver: defaults, what does not go together, and the profiles that come with
 * the service. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "daemon/config.h"

#include <errno.h>
#include <math.h>
#include <string.h>

#define V4L2 "streams:\n  - name: a\n    v4l2: "

static void load(struct dx_config *c, const char *path)
{
    struct dx_err err = {""};

    if (dx_config_load(c, path, &err))
        fail_msg("%s", err.text);
    assert_int_equal(c->n_streams, 1);
    assert_string_equal(c->streams[0].driver, "v4l2");
}

static void test_defaults(void **state)
{
    static const char text[] = V4L2 "{fx: 425}";
    struct dx_v4l2_config *v;
    struct dx_config c;
    struct dx_err err = {""};

    (void)state;
    if (dx_config_parse(&c, "t.yaml", text, strlen(text), &err))
        fail_msg("%s", err.text);
    v = &c.streams[0].source.v4l2;
    assert_true(!*v->serial && !*v->port && !*v->path);
    assert_int_equal(v->format, DX_V4L2_AUTO);
    assert_true(v->width == 0 && v->height == 0 && v->fps == 0);
    assert_true(v->unit_m == 0.001 && !v->disparity_given && v->invalid == 0);
    assert_true(v->min_m == 0 && v->max_m == 0);
    assert_true(v->lens.fx == 425 && v->lens.fy == 0);
    assert_true(v->lens.cx == DX_LENS_CENTRE && v->lens.cy == DX_LENS_CENTRE);
    assert_true(dx_lens_is_straight(&v->lens));
    dx_config_fini(&c);
}

static void test_all(void **state)
{
    static const char text[] = V4L2
        "{serial: 00AB_7, port: 1-2.3, path: /dev/v4l/by-path/x, format: Y16_BE, size: 320x240,\n"
        "      fps: 12.5, unit: 0.0001, disparity: [-640, 2.5], invalid: 65535, min_depth: 0.3,\n"
        "      max_depth: 4, fx: 300, fy: 301, cx: -2.5, cy: 119.25, k1: -0.1, k2: 0.2, p1: "
        "0.003,\n"
        "      p2: -0.004, k3: 0.5}";
    struct dx_v4l2_config *v;
    struct dx_config c;
    struct dx_err err = {""};

    (void)state;
    if (dx_config_parse(&c, "t.yaml", text, strlen(text), &err))
        fail_msg("%s", err.text);
    v = &c.streams[0].source.v4l2;
    assert_string_equal(v->serial, "00AB_7");
    assert_string_equal(v->port, "1-2.3");
    assert_string_equal(v->path, "/dev/v4l/by-path/x");
    assert_int_equal(v->format, DX_V4L2_Y16_BE);
    assert_true(v->width == 320 && v->height == 240 && v->fps == 12.5);
    assert_true(v->unit_m == 0.0001 && v->invalid == 65535);
    assert_true(v->disparity_given && v->disparity[0] == -640 && v->disparity[1] == 2.5);
    assert_true(v->min_m == 0.3 && v->max_m == 4);
    assert_true(v->lens.fx == 300 && v->lens.fy == 301 && v->lens.cx == -2.5 &&
                v->lens.cy == 119.25);
    assert_true(v->lens.k1 == -0.1 && v->lens.k2 == 0.2 && v->lens.p1 == 0.003 &&
                v->lens.p2 == -0.004 && v->lens.k3 == 0.5);
    dx_config_fini(&c);
}

static void test_errors(void **state)
{
    static const struct {
        const char *yaml, *text;
    } bad[] = {
        {V4L2, "t.yaml:3:10: streams[0].v4l2.fx: missing, expected a number from 1 to 1000000"},
        {V4L2 "{fx: 4, serial: a b}",
         "t.yaml:3:27: streams[0].v4l2.serial: found 'a b', expected 0 to 63 letters, digits and . "
         "_ -"},
        {V4L2 "{fx: 4, format: YUYV}",
         "t.yaml:3:27: streams[0].v4l2.format: found 'YUYV', expected auto, Z16, INZI, Y16, "
         "Y16_BE, Y14, Y12, Y10 or Y10B"},
        {V4L2 "{fx: 4, min_depth: 3, max_depth: 2}",
         "t.yaml:3:44: streams[0].v4l2.max_depth: expected 0, or more than min_depth"},
        {V4L2 "{fx: 4, disparity: [0, 5]}",
         "t.yaml:3:30: streams[0].v4l2.disparity: expected [k, d0], k not 0"},
        {V4L2 "{fx: 4, disparity: [1, 2, 3]}",
         "t.yaml:3:30: streams[0].v4l2.disparity: expected [k, d0], k not 0"},
        {V4L2 "{fx: 4, format: Y10B, size: 6x4}",
         "t.yaml:3:39: streams[0].v4l2.size: Y10B has columns by fours"},
    };

    (void)state;
    for (size_t k = 0; k < sizeof(bad) / sizeof(bad[0]); k++) {
        struct dx_config c;
        struct dx_err err = {""};

        assert_int_equal(dx_config_parse(&c, "t.yaml", bad[k].yaml, strlen(bad[k].yaml), &err),
                         -EINVAL);
        assert_string_equal(err.text, bad[k].text);
        dx_config_fini(&c);
    }
}

static void test_realsense(void **state)
{
    struct dx_v4l2_config *v;
    struct dx_config c;

    (void)state;
    load(&c, "config/sensors/realsense-d4xx.yaml");
    v = &c.streams[0].source.v4l2;
    assert_int_equal(v->format, DX_V4L2_Z16);
    assert_true(v->width == 848 && v->height == 480 && v->unit_m == 0.001);
    /* the noise is what the comment derives */
    assert_true(c.streams[0].mesh.sigma_given);
    assert_true(fabs(c.streams[0].mesh.sigma[2] - 0.08 / (v->lens.fx * 0.050)) < 5e-5);
    dx_config_fini(&c);
}

static void test_kinect(void **state)
{
    const double s = 200, e = 7.5, R = 120, p = 0.1042;
    struct dx_v4l2_config *v;
    struct dx_config c;

    (void)state;
    load(&c, "config/sensors/kinect-v1-v4l2.yaml");
    v = &c.streams[0].source.v4l2;
    assert_int_equal(v->format, DX_V4L2_Y10B);
    assert_true(fabs(v->disparity[0] - 40 * R * e / p / 1000) < 1e-3);
    assert_true(fabs(v->disparity[1] - (4 * e / p + 4 * (s + 0.375))) < 1e-3);
    assert_true(fabs(v->lens.fx - R / (2 * p)) < 0.05);
    dx_config_fini(&c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_defaults), cmocka_unit_test(test_all),
        cmocka_unit_test(test_errors),   cmocka_unit_test(test_realsense),
        cmocka_unit_test(test_kinect),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
