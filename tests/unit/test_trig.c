/* Elementary functions: against libm within the stated bounds, and the same bits everywhere. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "core/base/bytes.h"
#include "core/base/hash.h"
#include "core/base/rng.h"
#include "core/base/trig.h"

#include <math.h>

#define BOUND 1e-14

static void expect_near(const char *what, double x, double got, double want, double bound)
{
    if (!(fabs(got - want) <= bound))
        fail_msg("%s(%.17g) = %.17g, libm %.17g", what, x, got, want);
}

static void check_sincos(double x)
{
    double s, c;

    dx_sincos(x, &s, &c);
    expect_near("sin", x, s, sin(x), BOUND);
    expect_near("cos", x, c, cos(x), BOUND);
    assert_true(s == dx_sin(x) && c == dx_cos(x));
}

static void sin_and_cos(void **state)
{
    (void)state;
    for (int k = -200000; k <= 200000; k++)
        check_sincos(k * 1e-4);
    for (int k = -100000; k <= 100000; k++)
        check_sincos(k * 10.0 + 0.123);
    /* next to the ends of the quadrants, where the reduction cancels */
    for (int k = -600000; k <= 600000; k += 7)
        check_sincos(k * (DX_PI / 2));
}

static void sin_and_cos_have_exact_points(void **state)
{
    (void)state;
    assert_true(dx_sin(0) == 0 && dx_cos(0) == 1);
    assert_true(dx_cos(DX_PI) == -1 && dx_sin(DX_PI / 2) == 1);
    for (int k = 1; k < 20000; k++) {
        assert_true(dx_sin(-k * 1e-3) == -dx_sin(k * 1e-3));
        assert_true(dx_cos(-k * 1e-3) == dx_cos(k * 1e-3));
    }
}

static void tangent(void **state)
{
    (void)state;
    for (int k = -15000; k <= 15000; k++) {
        double x = k * 1e-4;

        expect_near("tan", x, dx_tan(x), tan(x), BOUND * (1 + fabs(tan(x))));
    }
}

static void arcs(void **state)
{
    struct dx_rng rng = dx_rng_init(1, 1);

    (void)state;
    for (int k = 0; k < 500000; k++) {
        double x = (2 * dx_rng_unit(&rng) - 1) * (k % 3 ? 1 : 1e-8);
        double y = (2 * dx_rng_unit(&rng) - 1) * (k % 5 ? 1 : 1e8);

        expect_near("atan2", y / x, dx_atan2(y, x), atan2(y, x), BOUND);
        assert_true(dx_atan2(-y, x) == -dx_atan2(y, x));
    }
    for (int k = -100000; k <= 100000; k++)
        expect_near("acos", k * 1e-5, dx_acos(k * 1e-5), acos(k * 1e-5), BOUND);
    assert_true(dx_acos(1.5) == 0 && dx_acos(-1.5) == DX_PI);
}

static void arcs_on_the_axes(void **state)
{
    (void)state;
    assert_true(dx_atan2(0, 0) == 0);
    assert_true(dx_atan2(0, 1) == 0 && dx_atan2(0, -1) == DX_PI);
    assert_true(dx_atan2(-0.0, -1) == DX_PI);
    assert_true(dx_atan2(2, 0) == DX_PI / 2 && dx_atan2(-2, 0) == -DX_PI / 2);
    assert_true(fabs(dx_atan2(1, 1) - DX_PI / 4) < BOUND);
}

static void exp_and_log(void **state)
{
    (void)state;
    for (int k = -700000; k <= 700000; k++) {
        double x = k * 1e-3;

        expect_near("exp", x, dx_exp(x) / exp(x), 1, BOUND);
    }
    for (int k = 1; k <= 1000000; k++) {
        double x = k * 1e-5, want = log(x);

        expect_near("log", x, dx_log(x), want, BOUND * fabs(want));
    }
    for (int k = -1000; k <= 1000; k++) {
        double x = dx_exp(k * 0.7), want = log(x);

        expect_near("log", x, dx_log(x), want, BOUND * fabs(want));
    }
    assert_true(dx_log(1) == 0 && dx_exp(0) == 1);
}

/* Compilers, optimisation levels and machines must agree on every bit. */
static void bits_are_golden(void **state)
{
    struct dx_rng rng = dx_rng_init(2, 2);
    uint64_t h = 0;

    (void)state;
    for (int k = 0; k < 100000; k++) {
        double x = (2 * dx_rng_unit(&rng) - 1) * 1000, y = (2 * dx_rng_unit(&rng) - 1), s, c;

        dx_sincos(x, &s, &c);
        h = dx_hash_u64(h, dx_f64_bits(s));
        h = dx_hash_u64(h, dx_f64_bits(c));
        h = dx_hash_u64(h, dx_f64_bits(dx_atan2(y, x)));
        h = dx_hash_u64(h, dx_f64_bits(dx_atan2(x, y)));
        h = dx_hash_u64(h, dx_f64_bits(dx_acos(y)));
        h = dx_hash_u64(h, dx_f64_bits(dx_exp(x * 0.5)));
        h = dx_hash_u64(h, dx_f64_bits(dx_log(fabs(x) + 1e-300)));
    }
    if (h != 0x3f8a0a9da9639d97)
        fail_msg("hash of the bits is 0x%016llx", (unsigned long long)h);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sin_and_cos),      cmocka_unit_test(sin_and_cos_have_exact_points),
        cmocka_unit_test(tangent),          cmocka_unit_test(arcs),
        cmocka_unit_test(arcs_on_the_axes), cmocka_unit_test(exp_and_log),
        cmocka_unit_test(bits_are_golden),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
