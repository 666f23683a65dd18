/* Random numbers: moments, shape, independence of streams, and the same bits everywhere. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "core/base/bytes.h"
#include "core/base/rng.h"
#include "core/base/trig.h"

#include <math.h>

#define N 1000000

static void expect_within(const char *what, double got, double want, double bound)
{
    if (!(fabs(got - want) <= bound))
        fail_msg("%s is %g, expected %g within %g", what, got, want, bound);
}

static void unit_is_uniform(void **state)
{
    struct dx_rng rng = dx_rng_init(3, 1);
    double sum = 0, sum2 = 0;
    int bin[16] = {0};

    (void)state;
    for (int k = 0; k < N; k++) {
        double u = dx_rng_unit(&rng);

        assert_true(u >= 0 && u < 1);
        sum += u;
        sum2 += u * u;
        bin[(int)(u * 16)]++;
    }
    expect_within("mean", sum / N, 0.5, 0.0015);
    expect_within("second moment", sum2 / N, 1.0 / 3, 0.0015);
    for (int k = 0; k < 16; k++)
        expect_within("share of a sixteenth", bin[k] / (double)N, 1 / 16.0, 0.0013);
}

static void below_is_uniform(void **state)
{
    struct dx_rng rng = dx_rng_init(3, 2);
    int bin[7] = {0};

    (void)state;
    for (int k = 0; k < N; k++) {
        uint32_t v = dx_rng_below(&rng, 7);

        assert_true(v < 7);
        bin[v]++;
    }
    for (int k = 0; k < 7; k++)
        expect_within("share of a seventh", bin[k] / (double)N, 1 / 7.0, 0.0018);
    for (int k = 0; k < 1000; k++)
        assert_int_equal(dx_rng_below(&rng, 1), 0);
}

static void normal_has_its_moments(void **state)
{
    double sum[5] = {0};
    int beyond_3 = 0;

    (void)state;
    for (int k = 0; k < N; k++) {
        struct dx_rng rng = dx_rng_init(4, (uint64_t)k); /* a stream a draw, as scenes do */
        double z = dx_rng_normal(&rng), power = 1;

        for (int m = 0; m < 5; m++, power *= z)
            sum[m] += power;
        beyond_3 += fabs(z) > 3;
    }
    expect_within("mean", sum[1] / N, 0, 0.005);
    expect_within("variance", sum[2] / N, 1, 0.007);
    expect_within("skewness", sum[3] / N, 0, 0.02);
    expect_within("kurtosis", sum[4] / N, 3, 0.05);
    expect_within("share beyond 3", beyond_3 / (double)N, 0.0027, 0.00026);
}

static void normal_follows_its_distribution(void **state)
{
    (void)state;
    for (uint64_t k = 0; k < 20000; k++) {
        struct dx_rng rng = dx_rng_init(5, k), same = rng;
        double u = dx_rng_unit(&same) + 0x1p-54, z = dx_rng_normal(&rng);

        expect_within("distribution at a draw", erfc(-z / sqrt(2)) / 2, u, 1e-14);
    }
}

/* Neighbouring streams (dexels) must not be alike. */
static void streams_are_independent(void **state)
{
    double lag[3] = {0};

    (void)state;
    for (uint64_t k = 0; k < N; k++) {
        const uint64_t stream[4] = {k, k + 1, k + 600, k ^ 0x100000000};
        double z[4];

        for (int m = 0; m < 4; m++) {
            struct dx_rng rng = dx_rng_init(6, stream[m]);

            z[m] = dx_rng_normal(&rng);
        }
        for (int m = 0; m < 3; m++)
            lag[m] += z[0] * z[m + 1];
    }
    for (int m = 0; m < 3; m++)
        expect_within("correlation of streams", lag[m] / N, 0, 0.005);
}

static void draws_depend_on_seed_and_stream_alone(void **state)
{
    struct dx_rng a = dx_rng_init(7, 8), b = dx_rng_init(7, 8), c = dx_rng_init(8, 7);
    struct dx_rng d = dx_rng_init(7, 9);
    uint64_t first = dx_rng_u64(&a);

    (void)state;
    dx_rng_u64(&d);
    assert_int_equal(first, dx_rng_u64(&b));
    assert_int_not_equal(first, dx_rng_u64(&c));
    assert_int_equal(dx_rng_u64(&a), dx_rng_u64(&b));
}

static void bits_are_golden(void **state)
{
    uint64_t h = 0;

    (void)state;
    for (uint64_t k = 0; k < 100000; k++) {
        struct dx_rng rng = dx_rng_init(9, k);

        h = dx_hash_u64(h, dx_rng_u64(&rng));
        h = dx_hash_u64(h, dx_rng_below(&rng, 1000));
        h = dx_hash_u64(h, dx_f64_bits(dx_rng_unit(&rng)));
        h = dx_hash_u64(h, dx_f64_bits(dx_rng_normal(&rng)));
    }
    if (h != 0x7a5dde36d120d6c8)
        fail_msg("hash of the bits is 0x%016llx", (unsigned long long)h);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(unit_is_uniform),
        cmocka_unit_test(below_is_uniform),
        cmocka_unit_test(normal_has_its_moments),
        cmocka_unit_test(normal_follows_its_distribution),
        cmocka_unit_test(streams_are_independent),
        cmocka_unit_test(draws_depend_on_seed_and_stream_alone),
        cmocka_unit_test(bits_are_golden),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
