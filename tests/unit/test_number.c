/* Number parser: against strtod in the C locale, at its limits, and on what is no number. */
#include "drivers/file/number.h"

#include "core/base/bytes.h"
#include "core/base/rng.h"

#include <inttypes.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <cmocka.h>

static double parse(const char *text)
{
    double v = 12345;
    const char *end = text + strlen(text);

    assert_ptr_equal(dx_number_parse(text, end, &v), end);
    return v;
}

static void assert_same_bits(const char *text, double want)
{
    double got = parse(text);

    if (dx_f64_bits(got) != dx_f64_bits(want))
        fail_msg("%s: got %a, expected %a", text, got, want);
}

static void test_known_values(void **state)
{
    static const char *const texts[] = {"0",
                                        "-0",
                                        "1",
                                        "+1",
                                        "-1.5",
                                        ".5",
                                        "5.",
                                        "0.1",
                                        "0.3",
                                        "123456.789",
                                        "1e22",
                                        "1e23",
                                        "8.5e-26",
                                        "9007199254740993",
                                        "9007199254740992.5",
                                        "0.000001",
                                        "-1.234567",
                                        "2.2250738585072014e-10",
                                        "1.7976931348623157e27",
                                        "00000000000000000000001.5",
                                        "0.00000000000000000000000012345",
                                        "9999999999999999999",
                                        "1E5",
                                        "1e+05",
                                        "4.35",
                                        "0.6822871999174"};

    (void)state;
    for (size_t k = 0; k < sizeof(texts) / sizeof(texts[0]); k++)
        assert_same_bits(texts[k], strtod(texts[k], NULL));
}

/* Every printed form of random doubles, up to 19 digits, comes back as strtod reads it. */
static void test_random_against_strtod(void **state)
{
    struct dx_rng g = dx_rng_init(7, 1);
    char text[64];

    (void)state;
    for (int k = 0; k < 300000; k++) {
        int digits = 1 + (int)dx_rng_below(&g, 19), power = (int)dx_rng_below(&g, 16) - 8;
        double v = (1 + 9 * dx_rng_unit(&g)) * (k & 2 ? 1 : -1);

        for (int p = 0; p < abs(power); p++)
            v = power < 0 ? v / 10 : v * 10;
        snprintf(text, sizeof(text), k & 1 ? "%.*g" : "%.*e", k & 1 ? digits : digits - 1, v);
        assert_same_bits(text, strtod(text, NULL));
    }
}

/* Halfway cases: an odd and an even mantissa with exactly half a unit, and just beside. */
static void test_halves(void **state)
{
    struct dx_rng g = dx_rng_init(7, 2);
    char text[64];

    (void)state;
    for (int k = 0; k < 100000; k++) {
        uint64_t m = ((uint64_t)1 << 53) + (dx_rng_u64(&g) >> 12);

        snprintf(text, sizeof(text), "%" PRIu64 "e%d", m * 2 + 1, (int)dx_rng_below(&g, 30) - 15);
        assert_same_bits(text, strtod(text, NULL));
    }
}

static void test_beyond_the_exact_range(void **state)
{
    static const char *const texts[] = {"1.5e-45",
                                        "2.3418052e-38",
                                        "3.14159e100",
                                        "1e-300",
                                        "123456789012345678901234567890",
                                        "0.1234567890123456789012345678901234567890"};

    (void)state;
    for (size_t k = 0; k < sizeof(texts) / sizeof(texts[0]); k++) {
        double want = strtod(texts[k], NULL);

        assert_true(fabs(parse(texts[k]) / want - 1) < 1e-14);
    }
    assert_true(isinf(parse("1e400")) && isinf(parse("-1e99999999999999999999")));
    assert_true(parse("1e-99999999999999999999") == 0);
    assert_true(parse("0e99999999999999999999") == 0);
}

static void test_words(void **state)
{
    (void)state;
    assert_true(isnan(parse("nan")) && isnan(parse("-NaN")) && isnan(parse("NAN")));
    assert_true(isinf(parse("inf")) && parse("-Infinity") < 0 && parse("+INF") > 0);
}

/* Where the number stops is told; no number is NULL; nothing at or after `end` is read. */
static void test_stops(void **state)
{
    static const char *const none[] = {"",   "-",   "+",  ".",  "-.", "e5",
                                       "x1", "--1", "na", "in", " 1"};
    const char *text = "12e+x";
    double v;

    (void)state;
    for (size_t k = 0; k < sizeof(none) / sizeof(none[0]); k++)
        assert_null(dx_number_parse(none[k], none[k] + strlen(none[k]), &v));
    assert_ptr_equal(dx_number_parse(text, text + 5, &v), text + 2);
    text = "1.5,2";
    assert_ptr_equal(dx_number_parse(text, text + 5, &v), text + 3);
    text = "1.2.3";
    assert_ptr_equal(dx_number_parse(text, text + 5, &v), text + 3);
    text = "123456";
    assert_ptr_equal(dx_number_parse(text, text + 3, &v), text + 3);
    assert_true(v == 123);
    text = "1e55";
    assert_ptr_equal(dx_number_parse(text, text + 3, &v), text + 3);
    assert_true(v == 1e5);
}

static void test_u64(void **state)
{
    static const char max[] = "18446744073709551615", over[] = "18446744073709551616";
    uint64_t v = 0;

    (void)state;
    assert_ptr_equal(dx_number_parse_u64(max, max + 20, &v), max + 20);
    assert_true(v == UINT64_MAX);
    assert_null(dx_number_parse_u64(over, over + 20, &v));

    assert_null(dx_number_parse_u64(max, max, &v));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_known_values), cmocka_unit_test(test_random_against_strtod),
        cmocka_unit_test(test_halves),       cmocka_unit_test(test_beyond_the_exact_range),
        cmocka_unit_test(test_words),        cmocka_unit_test(test_stops),
        cmocka_unit_test(test_u64),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
