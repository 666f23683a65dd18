/* The life of a device: every transition, the series of waits, random events. Time is the test's.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "core/base/rng.h"
#include "daemon/lifecycle.h"

#define S         1000000000ull
#define MS        1000000ull
#define START_NS  (1000 * S)
#define SILENT_NS (200 * MS)

static struct dx_life life(void)
{
    struct dx_life l;

    dx_life_init(&l, START_NS);
    assert_int_equal(l.state, DX_LIFE_OPENING);
    assert_int_equal(dx_life_step(&l, START_NS), DX_LIFE_OPEN);
    return l;
}

static struct dx_life streaming(void)
{
    struct dx_life l = life();

    dx_life_opened(&l, SILENT_NS, START_NS);
    assert_int_equal(l.state, DX_LIFE_OPENING);
    assert_int_equal(dx_life_step(&l, START_NS), DX_LIFE_READ);
    dx_life_tell(&l, DX_LIFE_BLOCK, START_NS);
    assert_int_equal(l.state, DX_LIFE_STREAMING);
    return l;
}

/* It waits until just before, and opens then. */
static void assert_opens_at(struct dx_life *l, uint64_t ns)
{
    assert_false(l->is_open);
    assert_int_equal(dx_life_step(l, ns - 1), DX_LIFE_WAIT);
    assert_int_equal(dx_life_step(l, ns), DX_LIFE_OPEN);
}

static void an_absent_device_waits_for_a_poke(void **state)
{
    struct dx_life l = life();

    (void)state;
    dx_life_tell(&l, DX_LIFE_NOT_THERE, START_NS);
    assert_int_equal(l.state, DX_LIFE_ABSENT);
    assert_opens_at(&l, START_NS + 30 * S);
    dx_life_tell(&l, DX_LIFE_NOT_THERE, START_NS + 30 * S);
    assert_opens_at(&l, START_NS + 60 * S);
    dx_life_tell(&l, DX_LIFE_NOT_THERE, START_NS + 60 * S);
    dx_life_tell(&l, DX_LIFE_POKE, START_NS + 62 * S);
    assert_int_equal(dx_life_step(&l, START_NS + 62 * S), DX_LIFE_OPEN);
    assert_int_equal(l.state, DX_LIFE_ABSENT);
    dx_life_opened(&l, SILENT_NS, START_NS + 62 * S);
    assert_int_equal(l.state, DX_LIFE_OPENING);
    assert_int_equal(l.since_ns, START_NS + 62 * S);
}

static void many_pokes_are_few_looks(void **state)
{
    struct dx_life l = life();
    unsigned n = 0;

    (void)state;
    dx_life_tell(&l, DX_LIFE_NOT_THERE, START_NS);
    for (uint64_t t = START_NS; t < START_NS + S; t += MS) {
        dx_life_tell(&l, DX_LIFE_POKE, t);
        if (dx_life_step(&l, t) != DX_LIFE_OPEN)
            continue;
        dx_life_tell(&l, DX_LIFE_NOT_THERE, t);
        n++;
    }
    assert_int_equal(n, 19);
}

static void faults_back_off(void **state)
{
    static const unsigned series[] = {1, 2, 4, 8, 16, 30, 30};
    struct dx_life l = life();
    uint64_t now = START_NS;

    (void)state;
    for (size_t k = 0; k < sizeof(series) / sizeof(series[0]); k++) {
        dx_life_tell(&l, DX_LIFE_FAILED, now);
        assert_int_equal(l.state, DX_LIFE_FAULTED);
        assert_opens_at(&l, now + series[k] * S);
        now += series[k] * S;
    }
    dx_life_opened(&l, SILENT_NS, now); /* a short stay does not begin the series anew */
    dx_life_tell(&l, DX_LIFE_BLOCK, now);
    dx_life_tell(&l, DX_LIFE_FAILED, now + 9 * S);
    assert_opens_at(&l, now + 39 * S);
    now += 39 * S;
    dx_life_opened(&l, SILENT_NS, now); /* a long one does */
    for (unsigned k = 0; k <= 100; k++)
        dx_life_tell(&l, DX_LIFE_BLOCK, now + k * 100 * MS);
    dx_life_tell(&l, DX_LIFE_FAILED, now + 10 * S);
    assert_opens_at(&l, now + 11 * S);
}

/* Stalls in between: it has not been well for ten seconds. */
static void a_halting_device_is_not_healthy(void **state)
{
    struct dx_life l = life();
    uint64_t now = START_NS;

    (void)state;
    for (unsigned k = 0; k < 3; k++) {
        dx_life_tell(&l, DX_LIFE_FAILED, now);
        now = l.due_ns;
        assert_int_equal(dx_life_step(&l, now), DX_LIFE_OPEN);
    }
    dx_life_opened(&l, SILENT_NS, now);
    for (unsigned k = 0; k < 20; k++, now += S) {
        dx_life_tell(&l, DX_LIFE_BLOCK, now);
        dx_life_tell(&l, DX_LIFE_QUIET, now + SILENT_NS);
        assert_int_equal(l.state, DX_LIFE_STALLED);
    }
    dx_life_tell(&l, DX_LIFE_FAILED, now);
    assert_opens_at(&l, now + 8 * S);
}

static void a_poke_cuts_one_wait_in_ten_seconds(void **state)
{
    struct dx_life l = life();
    uint64_t now = START_NS;

    (void)state;
    for (unsigned k = 0; k < 5; k++) { /* 16 s to wait */
        dx_life_tell(&l, DX_LIFE_FAILED, now);
        now = l.due_ns;
        assert_int_equal(dx_life_step(&l, now), DX_LIFE_OPEN);
    }
    dx_life_tell(&l, DX_LIFE_FAILED, now); /* 30 */
    dx_life_tell(&l, DX_LIFE_POKE, now + 100 * MS);
    assert_opens_at(&l, now + S);
    dx_life_tell(&l, DX_LIFE_FAILED, now + S);
    dx_life_tell(&l, DX_LIFE_POKE, now + 2 * S);
    assert_int_equal(dx_life_step(&l, now + 5 * S), DX_LIFE_WAIT);
    dx_life_tell(&l, DX_LIFE_POKE, now + 11 * S);
    assert_int_equal(dx_life_step(&l, now + 11 * S), DX_LIFE_OPEN);
}

static void silence_is_a_stall_and_then_a_fault(void **state)
{
    struct dx_life l = streaming();
    uint64_t now = START_NS;

    (void)state;
    dx_life_tell(&l, DX_LIFE_QUIET, now + SILENT_NS - 1);
    assert_int_equal(l.state, DX_LIFE_STREAMING);
    dx_life_tell(&l, DX_LIFE_QUIET, now + SILENT_NS);
    assert_int_equal(l.state, DX_LIFE_STALLED);
    assert_int_equal(dx_life_step(&l, now + SILENT_NS), DX_LIFE_READ);
    dx_life_tell(&l, DX_LIFE_BLOCK, now + S);
    assert_int_equal(l.state, DX_LIFE_STREAMING);
    dx_life_tell(&l, DX_LIFE_QUIET, now + 2 * S);
    dx_life_tell(&l, DX_LIFE_QUIET, now + 7 * S - 1);
    assert_int_equal(l.state, DX_LIFE_STALLED);
    dx_life_tell(&l, DX_LIFE_QUIET, now + 7 * S);
    assert_int_equal(l.state, DX_LIFE_FAULTED);
    assert_opens_at(&l, now + 8 * S);
}

/* A device may take a while to get going, and a slow one is silent for long. */
static void the_first_block_has_more_time(void **state)
{
    struct dx_life l = life();

    (void)state;
    dx_life_opened(&l, SILENT_NS, START_NS);
    dx_life_tell(&l, DX_LIFE_QUIET, START_NS + 5 * S - 1);
    assert_int_equal(l.state, DX_LIFE_OPENING);
    dx_life_tell(&l, DX_LIFE_QUIET, START_NS + 5 * S);
    assert_int_equal(l.state, DX_LIFE_STALLED);
    l = life();
    dx_life_opened(&l, 20 * S, START_NS);
    dx_life_tell(&l, DX_LIFE_QUIET, START_NS + 19 * S);
    assert_int_equal(l.state, DX_LIFE_OPENING);
    dx_life_tell(&l, DX_LIFE_QUIET, START_NS + 20 * S);
    dx_life_tell(&l, DX_LIFE_QUIET, START_NS + 39 * S);
    assert_int_equal(l.state, DX_LIFE_STALLED);
    dx_life_tell(&l, DX_LIFE_QUIET, START_NS + 40 * S);
    assert_int_equal(l.state, DX_LIFE_FAULTED);
}

static void a_device_that_went_is_looked_for(void **state)
{
    struct dx_life l = streaming();
    uint64_t now = START_NS + S;

    (void)state;
    dx_life_tell(&l, DX_LIFE_WENT, now);
    assert_int_equal(l.state, DX_LIFE_GONE);
    assert_opens_at(&l, now + S);
    dx_life_tell(&l, DX_LIFE_NOT_THERE, now + S);
    assert_int_equal(l.state, DX_LIFE_GONE); /* not absent: it was there */
    assert_opens_at(&l, now + 3 * S);
    dx_life_tell(&l, DX_LIFE_NOT_THERE, now + 3 * S);
    dx_life_tell(&l, DX_LIFE_POKE, now + 3 * S);
    assert_opens_at(&l, now + 3 * S + 50 * MS);
    dx_life_tell(&l, DX_LIFE_FAILED, now + 4 * S);
    assert_int_equal(l.state, DX_LIFE_FAULTED);
    dx_life_tell(&l, DX_LIFE_NOT_THERE, now + 12 * S);
    assert_int_equal(l.state, DX_LIFE_GONE);
}

static void pokes_do_not_touch_an_open_device(void **state)
{
    struct dx_life l = streaming(), before = l;

    (void)state;
    dx_life_tell(&l, DX_LIFE_POKE, START_NS + S);
    assert_memory_equal(&l, &before, sizeof(l));
}

/* What a step allows, at random and in random time: it looks again within half a minute always, and
 * not more than twenty times a second ever. */
static void random_events_never_stick_and_never_spin(void **state)
{
    static const enum dx_life_event closed[] = {DX_LIFE_NOT_THERE, DX_LIFE_FAILED};
    static const enum dx_life_event open[] = {DX_LIFE_BLOCK,  DX_LIFE_BLOCK, DX_LIFE_QUIET,
                                              DX_LIFE_FAILED, DX_LIFE_WENT,  DX_LIFE_QUIET};
    uint64_t now = START_NS, tried = 0, seen = 0, n_opens = 0;
    struct dx_life l;
    struct dx_rng rng = dx_rng_init(7, 0);

    (void)state;
    dx_life_init(&l, now);
    for (unsigned k = 0; k < 100000; k++) {
        uint64_t dice = dx_rng_u64(&rng);

        now += (dice & 7) == 0 ? dice >> 8 & 0xfffffffff : dice >> 8 & 0xffffff;
        if ((dice >> 3 & 3) == 0)
            dx_life_tell(&l, DX_LIFE_POKE, now);
        switch (dx_life_step(&l, now)) {
        case DX_LIFE_WAIT:
            assert_true(l.due_ns > now && l.due_ns <= now + 30 * S);
            assert_false(l.is_open);
            break;
        case DX_LIFE_OPEN:
            assert_true(tried == 0 || now - tried >= DX_LIFE_PAUSE_NS);
            tried = now;
            n_opens++;
            if (dice & 32)
                dx_life_opened(&l, dice >> 40 & 0xffffffff, now);
            else
                dx_life_tell(&l, closed[dice >> 6 & 1], now);
            break;
        case DX_LIFE_READ:
            assert_true(l.state == DX_LIFE_OPENING || l.state == DX_LIFE_STREAMING ||
                        l.state == DX_LIFE_STALLED);
            dx_life_tell(&l, open[(dice >> 33) % 6], now);
            break;
        }
        assert_true(l.since_ns <= now);
        seen |= 1u << l.state;
    }
    assert_int_equal(seen | 1u << DX_LIFE_ABSENT, (1u << (DX_LIFE_GONE + 1)) - 1);
    assert_true(n_opens > 1000);
}

static void states_have_names(void **state)
{
    (void)state;
    assert_string_equal(dx_life_state_name(DX_LIFE_ABSENT), "absent");
    assert_string_equal(dx_life_state_name(DX_LIFE_GONE), "gone");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_absent_device_waits_for_a_poke),
        cmocka_unit_test(many_pokes_are_few_looks),
        cmocka_unit_test(faults_back_off),
        cmocka_unit_test(a_halting_device_is_not_healthy),
        cmocka_unit_test(a_poke_cuts_one_wait_in_ten_seconds),
        cmocka_unit_test(silence_is_a_stall_and_then_a_fault),
        cmocka_unit_test(the_first_block_has_more_time),
        cmocka_unit_test(a_device_that_went_is_looked_for),
        cmocka_unit_test(pokes_do_not_touch_an_open_device),
        cmocka_unit_test(random_events_never_stick_and_never_spin),
        cmocka_unit_test(states_have_names),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
