/* The integer noise model against the same sum in 128 bits and in doubles. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "core/base/rng.h"
#include "core/grid/sigma.h"

#include <math.h>

static uint32_t exact(const double sigma[3], double u, uint32_t r)
{
    double s0 = sigma[0] > 0.5 * u ? sigma[0] : 0.5 * u;
    unsigned __int128 v = (unsigned __int128)rint(256 * s0 / u);

    v += (unsigned __int128)r * (uint64_t)rint(0x1p24 * sigma[1]) >> 16;
    v += ((unsigned __int128)((uint64_t)r * r >> 16) * (uint64_t)rint(0x1p40 * sigma[2] * u)) >> 16;
    return v < DX_SIGMA_MAX ? (uint32_t)v : DX_SIGMA_MAX;
}

static void equals_the_sum_in_128_bits(void **state)
{
    static const uint32_t ends[] = {0, 1, 255, 256, 257, 65535, 65536, 1u << 24, UINT32_MAX};
    struct dx_rng rng = dx_rng_init(1, 0);

    (void)state;
    for (int round = 0; round < 3000; round++) {
        double scale = round % 3 == 0 ? 1000 : round % 3 == 1 ? 1 : 1e-4;
        double u = round % 5 == 0 ? 1000 : round % 5 == 1 ? 1e-6 : 1e-3, sigma[3];
        struct dx_sigma s;

        for (int k = 0; k < 3; k++)
            sigma[k] = dx_rng_below(&rng, 3) ? scale * dx_rng_unit(&rng) : 0;
        dx_sigma_init(&s, sigma, u);
        for (size_t k = 0; k < sizeof(ends) / sizeof(ends[0]); k++)
            assert_int_equal(dx_sigma_at(&s, ends[k]), exact(sigma, u, ends[k]));
        for (int k = 0; k < 100; k++) {
            uint32_t r = (uint32_t)(dx_rng_u64(&rng) >> (32 + dx_rng_below(&rng, 32)));

            assert_int_equal(dx_sigma_at(&s, r), exact(sigma, u, r));
        }
        if (s.full > 0 && s.full < UINT32_MAX - 1)
            for (uint32_t r = s.full - 1; r <= s.full + 1; r++)
                assert_int_equal(dx_sigma_at(&s, r), exact(sigma, u, r));
    }
}

static void is_the_noise_in_a_256th_of_a_unit(void **state)
{
    static const double sigma[3] = {0.004, 0.0002, 1e-5};
    struct dx_sigma s;

    (void)state;
    dx_sigma_init(&s, sigma, 0.001);
    for (uint32_t r = 0; r < 65536; r += 17) {
        double m = r * 0.001, want = sigma[0] + sigma[1] * m + sigma[2] * m * m;

        assert_true(fabs(dx_sigma_at(&s, r) / 256.0 * 0.001 - want) < 0.02 * 0.001);
    }
}

static void is_never_below_half_a_unit(void **state)
{
    static const double none[3] = {0, 0, 0};
    struct dx_sigma s;

    (void)state;
    dx_sigma_init(&s, none, 0.002);
    assert_int_equal(dx_sigma_at(&s, 0), 128);
    assert_int_equal(dx_sigma_at(&s, UINT32_MAX), 128);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equals_the_sum_in_128_bits),
        cmocka_unit_test(is_the_noise_in_a_256th_of_a_unit),
        cmocka_unit_test(is_never_below_half_a_unit),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
