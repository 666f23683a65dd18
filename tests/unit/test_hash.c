/* The content hash: every bit and the length count, no collisions among small inputs, golden
 * values. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "core/base/hash.h"

#include <stdlib.h>
#include <string.h>

static int by_value(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;

    return (x > y) - (x < y);
}

static void expect_distinct(uint64_t *h, size_t n)
{
    qsort(h, n, sizeof(*h), by_value);
    for (size_t k = 1; k < n; k++)
        if (h[k] == h[k - 1])
            fail_msg("0x%016llx occurs twice", (unsigned long long)h[k]);
}

static void every_bit_counts(void **state)
{
    uint8_t bytes[100] = {0};

    (void)state;
    for (size_t len = 1; len <= sizeof(bytes); len++) {
        uint64_t h[1 + 8 * sizeof(bytes)];

        h[0] = dx_hash(0, bytes, len);
        for (size_t bit = 0; bit < 8 * len; bit++) {
            bytes[bit / 8] = (uint8_t)(1 << bit % 8);
            h[1 + bit] = dx_hash(0, bytes, len);
            bytes[bit / 8] = 0;
        }
        expect_distinct(h, 1 + 8 * len);
    }
}

static void length_counts(void **state)
{
    static uint8_t zeros[1000];
    uint64_t h[1001];

    (void)state;
    for (size_t len = 0; len <= 1000; len++)
        h[len] = dx_hash(0, zeros, len);
    expect_distinct(h, 1001);
}

static void order_and_seed_count(void **state)
{
    uint64_t words[8], h[64];

    (void)state;
    for (uint64_t k = 0; k < 8; k++)
        words[k] = k;
    for (size_t k = 0; k < 64; k++) { /* each pair of words exchanged; 0 with itself at k = 0 */
        uint64_t swapped[8];

        memcpy(swapped, words, sizeof(words));
        swapped[k / 8] = words[k % 8];
        swapped[k % 8] = words[k / 8];
        h[k] = dx_hash(k / 8 < k % 8 ? 0 : k + 1, swapped, sizeof(swapped));
    }
    expect_distinct(h, 64);
}

static void small_inputs_do_not_collide(void **state)
{
    const size_t n = 1 << 20;
    uint64_t *h = malloc(n * sizeof(*h));

    (void)state;
    assert_non_null(h);
    for (size_t k = 0; k < n; k++) {
        uint16_t ranges[24] = {0};

        ranges[k % 24] = (uint16_t)(k >> 10);
        ranges[(k + 5) % 24] = (uint16_t)k;
        h[k] = dx_hash(k % 24, ranges, sizeof(ranges));
    }
    expect_distinct(h, n);
    free(h);
}

/* A flipped input bit flips half of the output's. */
static void flips_spread(void **state)
{
    uint8_t bytes[64];
    uint64_t flips = 0;

    (void)state;
    for (size_t k = 0; k < sizeof(bytes); k++)
        bytes[k] = (uint8_t)(37 * k);
    uint64_t base = dx_hash(0, bytes, sizeof(bytes));
    for (size_t bit = 0; bit < 8 * sizeof(bytes); bit++) {
        bytes[bit / 8] ^= (uint8_t)(1 << bit % 8);
        int n = __builtin_popcountll(base ^ dx_hash(0, bytes, sizeof(bytes)));

        bytes[bit / 8] ^= (uint8_t)(1 << bit % 8);
        assert_in_range(n, 10, 54);
        flips += (uint64_t)n;
    }
    assert_in_range(flips / (8 * sizeof(bytes)), 31, 32);
}

static void any_alignment(void **state)
{
    uint8_t room[80];
    const char text[] = "the same forty-odd bytes at any address at all";
    uint64_t h = dx_hash(1, text, sizeof(text));

    (void)state;
    for (size_t off = 0; off < 16; off++) {
        memcpy(room + off, text, sizeof(text));
        assert_int_equal(dx_hash(1, room + off, sizeof(text)), h);
    }
}

static void bits_are_golden(void **state)
{
    uint8_t bytes[257];
    uint64_t h = 0;

    (void)state;
    for (size_t k = 0; k < sizeof(bytes); k++)
        bytes[k] = (uint8_t)(k * k + 3);
    for (size_t len = 0; len <= sizeof(bytes); len++)
        h = dx_hash(h, bytes, len);
    if (h != 0xacf62e9cd4bb4bfd)
        fail_msg("hash is 0x%016llx", (unsigned long long)h);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_bit_counts),     cmocka_unit_test(length_counts),
        cmocka_unit_test(order_and_seed_count), cmocka_unit_test(small_inputs_do_not_collide),
        cmocka_unit_test(flips_spread),         cmocka_unit_test(any_alignment),
        cmocka_unit_test(bits_are_golden),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
