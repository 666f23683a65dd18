/* The lens: Brown's model there and back, against values worked out by hand; where it folds; the
 * geometries made of it. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "core/base/hash.h"
#include "core/base/bytes.h"
#include "drivers/lens.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A wide camera's barrel with a little of everything. */
static const struct dx_lens barrel = {.fx = 400,
                                      .fy = 410,
                                      .cx = 320.5,
                                      .cy = 238,
                                      .k1 = -0.28,
                                      .k2 = 0.09,
                                      .p1 = 0.0007,
                                      .p2 = -0.0011,
                                      .k3 = -0.01};

static void near(double got, double want, double bound)
{
    if (!(fabs(got - want) <= bound))
        fail_msg("%.17g, expected %.17g", got, want);
}

/* With x = 0.5, y = -0.25: r2 = 0.3125; each coefficient alone. */
static void test_direct(void **state)
{
    const struct {
        struct dx_lens lens;
        double x, y;
    } want[] = {
        {{.k1 = 0.1}, 0.5 * 1.03125, -0.25 * 1.03125},
        {{.k2 = 0.1}, 0.5 * 1.009765625, -0.25 * 1.009765625},
        {{.k3 = 0.1}, 0.5 * 1.0030517578125, -0.25 * 1.0030517578125},
        {{.p1 = 0.1}, 0.5 - 0.025, -0.25 + 0.04375},
        {{.p2 = 0.1}, 0.5 + 0.08125, -0.25 - 0.025},
    };
    const double ray[2] = {0.5, -0.25};

    (void)state;
    for (size_t k = 0; k < sizeof(want) / sizeof(want[0]); k++) {
        double bent[2];

        dx_lens_distort(&want[k].lens, ray, bent);
        near(bent[0], want[k].x, 1e-15);
        near(bent[1], want[k].y, 1e-15);
        assert_false(dx_lens_is_straight(&want[k].lens));
    }
}

static void test_there_and_back(void **state)
{
    (void)state;
    for (double row = -2; row <= 480; row += 7.25)
        for (double col = -2; col <= 641; col += 7.25) {
            double ray[2], bent[2];

            assert_int_equal(dx_lens_ray(&barrel, row, col, ray), 0);
            dx_lens_distort(&barrel, ray, bent);
            near(bent[0] * barrel.fx + barrel.cx, col, 1e-9);
            near(bent[1] * barrel.fy + barrel.cy, row, 1e-9);
        }
}

/* And the other way: rays first. */
static void test_back_and_there(void **state)
{
    (void)state;
    for (double x = -0.7; x <= 0.7; x += 0.03)
        for (double y = -0.5; y <= 0.5; y += 0.03) {
            const double ray[2] = {x, y};
            double bent[2], back[2];

            dx_lens_distort(&barrel, ray, bent);
            assert_int_equal(dx_lens_ray(&barrel, bent[1] * barrel.fy + barrel.cy,
                                         bent[0] * barrel.fx + barrel.cx, back),
                             0);
            near(back[0], x, 1e-11);
            near(back[1], y, 1e-11);
        }
}

/* x (1 - 0.3 x^2) turns back at x = sqrt(1 / 0.9), where it is 0.7027: no ray is put beyond. */
static void test_fold(void **state)
{
    const struct dx_lens lens = {.fx = 100, .fy = 100, .k1 = -0.3};
    struct dx_geometry *g = NULL;
    struct dx_err err;
    double ray[2];

    (void)state;
    assert_int_equal(dx_lens_ray(&lens, 0, 70, ray), 0);
    near(ray[0] * (1 - 0.3 * ray[0] * ray[0]), 0.7, 1e-12);
    assert_true(ray[0] < sqrt(1 / 0.9));
    assert_int_equal(dx_lens_ray(&lens, 0, 71, ray), -ERANGE);
    assert_int_equal(dx_lens_ray(&lens, 1e300, -1e300, ray), -ERANGE);

    assert_int_equal(dx_lens_geometry(&g, &lens, 60, 80, &err), -EINVAL);
    assert_null(g);
    assert_non_null(strstr(err.text, "folds the image before pixel (71, 0)"));
}

static void test_settle(void **state)
{
    struct dx_lens lens = {.fx = 500, .cx = DX_LENS_CENTRE, .cy = DX_LENS_CENTRE};

    (void)state;
    dx_lens_settle(&lens, 480, 640);
    assert_true(lens.fy == 500 && lens.cx == 319.5 && lens.cy == 239.5);
    lens = (struct dx_lens){.fx = 500, .fy = 400, .cx = -3, .cy = 0};
    dx_lens_settle(&lens, 480, 640);
    assert_true(lens.fy == 400 && lens.cx == -3 && lens.cy == 0);
}

static void test_pinhole(void **state)
{
    const struct dx_lens lens = {.fx = 50, .fy = 40, .cx = 20, .cy = DX_LENS_CENTRE};
    struct dx_geometry *g;
    struct dx_err err;
    float p[3];

    (void)state;
    assert_int_equal(dx_lens_geometry(&g, &lens, 31, 41, &err), 0);
    assert_int_equal(g->model, DX_MODEL_PINHOLE);
    dx_geometry_point(g, 5, 30, 2000, p); /* 2 m deep: x = 2 * 10 / 50, y = 2 * -10 / 40 */
    near((double)p[0], 0.4, 1e-6);
    near((double)p[1], -0.5, 1e-6);
    near((double)p[2], 2, 1e-6);
    dx_geometry_unref(g);

    assert_int_equal(dx_lens_geometry(&g, &(struct dx_lens){.fx = 0}, 31, 41, &err), -EINVAL);
    assert_int_equal(dx_lens_geometry(&g, &lens, 0, 41, &err), -EINVAL);
}

/* A dexel of the table, its range being depth times stretch, is the point that the ray says. */
static void test_table(void **state)
{
    struct dx_geometry *g;
    struct dx_err err;
    float *stretch;

    (void)state;
    assert_int_equal(dx_lens_geometry(&g, &barrel, 480, 640, &err), 0);
    assert_int_equal(g->model, DX_MODEL_TABLE);
    stretch = calloc((size_t)480 * 640, sizeof(*stretch));
    dx_lens_stretch(stretch, g);
    for (uint32_t i = 0; i < 480; i += 37)
        for (uint32_t j = 0; j < 640; j += 41) {
            uint32_t range = (uint32_t)rint(3000 * (double)stretch[i * 640 + j]);
            double ray[2], dir[3], len2;
            float p[3];

            assert_int_equal(dx_lens_ray(&barrel, i, j, ray), 0);
            dx_geometry_point(g, i, j, range, p);
            near((double)p[0], 3 * ray[0], 0.0006);
            near((double)p[1], 3 * ray[1], 0.0006);
            near((double)p[2], 3, 0.0006);
            dx_geometry_direction(g, i, j, dir);
            len2 = dir[0] * dir[0] + dir[1] * dir[1] + dir[2] * dir[2];
            near(len2, 1, 1e-12);
        }
    free(stretch);
    dx_geometry_unref(g);
}

/* Seen from the scanner, columns run to the right and rows down, straight or bent alike. */
static void test_orientation(void **state)
{
    struct dx_lens straight = barrel;
    struct dx_geometry *bent, *plain;
    struct dx_err err;

    (void)state;
    straight.k1 = straight.k2 = straight.k3 = straight.p1 = straight.p2 = 0;
    assert_int_equal(dx_lens_geometry(&bent, &barrel, 48, 64, &err), 0);
    assert_int_equal(dx_lens_geometry(&plain, &straight, 48, 64, &err), 0);
    assert_int_equal(bent->flip, plain->flip);
    for (uint32_t i = 0; i + 1 < 48; i++)
        for (uint32_t j = 0; j + 1 < 64; j++)
            assert_int_equal(dx_geometry_cell_sign(bent, i, j), bent->flip ? 1 : -1);
    dx_geometry_unref(bent);
    dx_geometry_unref(plain);
}

/* What clients rebuild points from is the same on every machine and of every compiler. */
static void test_same_bits(void **state)
{
    struct dx_geometry *g;
    struct dx_err err;
    uint64_t h = 0;

    (void)state;
    assert_int_equal(dx_lens_geometry(&g, &barrel, 480, 640, &err), 0);
    for (size_t k = 0; k < g->n_table; k++)
        h = dx_hash_u64(h, dx_f32_bits(g->table[k]));
    if (h != 0xfb85dbfdda3afc58ull)
        fail_msg("digest of the table is %016llx", (unsigned long long)h);
    dx_geometry_unref(g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_direct),         cmocka_unit_test(test_there_and_back),
        cmocka_unit_test(test_back_and_there), cmocka_unit_test(test_fold),
        cmocka_unit_test(test_settle),         cmocka_unit_test(test_pinhole),
        cmocka_unit_test(test_table),          cmocka_unit_test(test_orientation),
        cmocka_unit_test(test_same_bits),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
