/* The scanner's clock: wraps, resets, the offset, and its drift. */
#include "drivers/hokuyo/scip_clock.h"

#include "core/base/rng.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <cmocka.h>

#define MS 1000000ull
#define S  (1000 * MS)

/* Over the wrap at 16777.216 s, twice. */
static void wraps(void **state)
{
    struct dx_scip_clock c;
    uint64_t ms = DX_SCIP_WRAP_MS - 500, first, got = 0;
    bool reset;

    (void)state;
    dx_scip_clock_init(&c);
    first = dx_scip_clock_unwrap(&c, (uint32_t)ms, 7 * S, &reset);
    assert_false(reset);
    for (uint64_t k = 1; k < 200; k++) {
        got = dx_scip_clock_unwrap(&c, (uint32_t)((ms + 25 * k) % DX_SCIP_WRAP_MS),
                                   7 * S + 25 * k * MS, &reset);
        assert_false(reset);
        assert_int_equal(got - first, 25 * k * MS);
    }
    /* away for 10 hours: two wraps that no stamp has shown */
    ms = (ms + 25 * 199 + 36000000) % DX_SCIP_WRAP_MS;
    assert_int_equal(
        dx_scip_clock_unwrap(&c, (uint32_t)ms, 7 * S + (25 * 199 + 36000000) * MS, &reset) - got,
        36000000 * MS);
    assert_false(reset);
}

static void resets(void **state)
{
    struct dx_scip_clock c;
    uint64_t before, after;
    bool reset;

    (void)state;
    dx_scip_clock_init(&c);
    dx_scip_clock_sample(&c, S, S + MS, 500 * S);
    assert_true(dx_scip_clock_settle(&c));
    dx_scip_clock_unwrap(&c, 500000, 10 * S, &reset);
    before = dx_scip_clock_unwrap(&c, 500025, 10 * S + 25 * MS, &reset);
    assert_false(reset);
    /* two that came together, in the wrong order */
    assert_int_equal(dx_scip_clock_unwrap(&c, 500020, 10 * S + 25 * MS, &reset), before - 5 * MS);
    assert_false(reset);
    after = dx_scip_clock_unwrap(&c, 40, 12 * S, &reset);
    assert_true(reset);
    assert_true(after > before); /* device time never runs backwards */
    assert_false(c.have_offset);
    assert_int_equal(dx_scip_clock_unwrap(&c, 65, 12 * S + 25 * MS, &reset) - after, 25 * MS);
    assert_false(reset);
}

/* Short exchanges tell it; long ones, that waited on one side, do not count. */
static void offset_by_the_short_exchanges(void **state)
{
    struct dx_scip_clock c;
    const int64_t offset = 123456789012;

    (void)state;
    dx_scip_clock_init(&c);
    assert_false(dx_scip_clock_settle(&c));
    for (uint64_t k = 0; k < 16; k++) {
        uint64_t mid = 1000 * S + k * 10 * MS, late = k % 4 == 2 ? 0 : 30 * MS;

        dx_scip_clock_sample(&c, mid - MS / 2, mid + MS / 2 + late,
                             (uint64_t)((int64_t)mid - offset));
    }
    assert_true(dx_scip_clock_settle(&c));
    assert_int_equal(c.offset_ns, offset);
    assert_int_equal(dx_scip_clock_host(&c, 5), 5 + (uint64_t)offset);
}

/* A crystal of +80 ppm for ten minutes, stamps of whole milliseconds, delays of up to 20 ms: the
 * mapping stays within a millisecond and a half. */
static void follows_the_drift(void **state)
{
    struct dx_scip_clock c;
    struct dx_rng rng = dx_rng_init(1, 2);
    const double skew = 80e-6;
    uint64_t host0 = 5000 * S;

    (void)state;
    dx_scip_clock_init(&c);
    for (int k = 0; k < 16; k++)
        dx_scip_clock_sample(&c, host0 - MS / 4, host0 + MS / 4, 100 * S);
    assert_true(dx_scip_clock_settle(&c));
    for (uint64_t k = 1; k < 24000; k++) {
        uint64_t at = host0 + k * 25 * MS;
        uint64_t device = 100 * S + (uint64_t)((double)(at - host0) * (1 + skew));
        uint64_t stamp = device / MS * MS;
        uint64_t delay = MS + dx_rng_u64(&rng) % (20 * MS);
        int64_t off;

        dx_scip_clock_arrival(&c, stamp, at + delay);
        off = (int64_t)(dx_scip_clock_host(&c, stamp) - at);
        assert_true(llabs(off) < (int64_t)(3 * MS / 2));
    }
}

/* A scanner that tells no time: the least delay stands for none. */
static void by_arrivals_alone(void **state)
{
    struct dx_scip_clock c;

    (void)state;
    dx_scip_clock_init(&c);
    for (uint64_t k = 0; k < 100; k++)
        dx_scip_clock_arrival(&c, k * 25 * MS, 77 * S + k * 25 * MS + (k % 7 + 1) * MS);
    assert_int_equal(dx_scip_clock_host(&c, 0), 77 * S + MS);
    assert_false(c.is_sampled);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wraps),
        cmocka_unit_test(resets),
        cmocka_unit_test(offset_by_the_short_exchanges),
        cmocka_unit_test(follows_the_drift),
        cmocka_unit_test(by_arrivals_alone),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
