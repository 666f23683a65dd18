/*
 * Trigger in: which edge belongs to which frame, with edges and frames that get lost; the pulse a
 * second; both, and trigger out, in a rig on lines of a script.
 */
#include "drivers/gpio/gpio_script.h"
#include "drivers/gpio/line_thread.h"
#include "drivers/gpio/pps.h"
#include "drivers/gpio/trigger_queue.h"
#include "drivers/monotonic.h"
#include "drivers/rig.h"

#include "core/base/rng.h"

#include <poll.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#define MS     1000000u
#define S      1000000000ll
#define PERIOD (33 * MS)

/* A camera at an even rate: an edge each period, its frame `delay` later. */
struct camera {
    struct dx_trigger_queue q;
    uint64_t n;
    uint64_t delay;
    bool last_right, last_paired;
};

static void begin(struct camera *c, uint64_t delay)
{
    memset(c, 0, sizeof(*c));
    dx_trigger_queue_init(&c->q, 200 * MS);
    c->delay = delay;
    c->n = 1;
}

static uint64_t edge_of(uint64_t n)
{
    return n * PERIOD;
}

/* Frame n: the edges up to its arrival are there, but for those that were lost. */
static void shoot(struct camera *c, bool has_edge, bool has_frame, uint64_t n_missed)
{
    uint64_t edge_ns = 0;

    if (has_edge)
        dx_trigger_queue_edge(&c->q, edge_of(c->n), 0, false);
    if (has_frame) {
        c->last_paired =
            dx_trigger_queue_frame(&c->q, edge_of(c->n) + c->delay, n_missed, &edge_ns);
        c->last_right = c->last_paired && edge_ns == edge_of(c->n);
    }
    c->n++;
}

static void expect_right(struct camera *c)
{
    shoot(c, true, true, 0);
    if (!c->last_right)
        fail_msg("frame %llu: %s", (unsigned long long)c->n - 1,
                 c->last_paired ? "another's edge" : "no edge");
}

static void pairs_in_order(void **state)
{
    struct camera c;

    (void)state;
    begin(&c, 20 * MS);
    for (int k = 0; k < 1000; k++)
        expect_right(&c);
    assert_int_equal(c.q.n_pairs, 1000);
    assert_int_equal(c.q.n_resyncs, 0);
}

static void lost_frames_take_their_edges(void **state)
{
    struct camera c;

    (void)state;
    begin(&c, 20 * MS);
    for (int k = 0; k < 10; k++)
        expect_right(&c);
    shoot(&c, true, false, 0); /* told by the driver */
    shoot(&c, true, false, 0);
    shoot(&c, true, true, 2);
    assert_true(c.last_right);
    assert_int_equal(c.q.n_resyncs, 0);
    for (int k = 0; k < 10; k++)
        expect_right(&c);
    shoot(&c, true, false, 0); /* and not told: the delay gives it away */
    expect_right(&c);
    assert_int_equal(c.q.n_resyncs, 1);
    for (int k = 0; k < 10; k++)
        expect_right(&c);
    assert_int_equal(c.q.n_resyncs, 1);
}

static void lost_edges_leave_a_frame_without(void **state)
{
    struct camera c;

    (void)state;
    begin(&c, 20 * MS);
    for (int k = 0; k < 10; k++)
        expect_right(&c);
    shoot(&c, false, true, 0);
    assert_false(c.last_paired);
    for (int k = 0; k < 10; k++)
        expect_right(&c);
    assert_int_equal(c.q.n_frames - c.q.n_pairs, 1);
}

/* Whatever gets lost, no frame has another's edge once the first has its own, with delays that vary
 * by less than half a period. */
static void never_takes_anothers(void **state)
{
    struct dx_rng rng = dx_rng_init(3, 0);
    struct camera c;
    int n_paired = 0;

    (void)state;
    begin(&c, 20 * MS);
    expect_right(&c);
    for (int k = 0; k < 20000; k++) {
        bool has_edge = dx_rng_below(&rng, 20) != 0, has_frame = dx_rng_below(&rng, 20) != 0;

        c.delay = 20 * MS + dx_rng_below(&rng, 8 * MS);
        shoot(&c, has_edge, has_frame, 0);
        if (has_frame && c.last_paired && !c.last_right)
            fail_msg("frame %d has another's edge", k);
        n_paired += has_frame && c.last_paired;
    }
    assert_true(n_paired > 17500);
}

static void forgets_what_no_frame_takes(void **state)
{
    struct camera c;

    (void)state;
    begin(&c, 20 * MS);
    for (uint32_t k = 0; k < 3 * DX_TRIGGER_QUEUE_LEN; k++)
        shoot(&c, true, false, 0); /* the device does not send yet */
    expect_right(&c);
    expect_right(&c);
    dx_trigger_queue_restart(&c.q);
    assert_false(dx_trigger_queue_frame(&c.q, edge_of(c.n), 0, &(uint64_t){0}));
    c.n++;
    expect_right(&c);
    assert_false(dx_trigger_queue_frame(&c.q, edge_of(c.n) + 900 * MS, 0, &(uint64_t){0}));
}

static void leaves_glitches_out(void **state)
{
    struct camera c;

    (void)state;
    begin(&c, 20 * MS);
    for (int k = 0; k < 100; k++) {
        dx_trigger_queue_edge(&c.q, edge_of(c.n), MS, false);
        dx_trigger_queue_edge(&c.q, edge_of(c.n) + 3000, MS, false);
        shoot(&c, false, true, 0);
        assert_true(c.last_right);
    }
    assert_int_equal(c.q.n_glitches, 100);
    assert_int_equal(c.q.n_resyncs, 0);
}

/* ---- the pulse a second
 * -------------------------------------------------------------------------- */

static void measures_the_second(void **state)
{
    struct dx_pps_state s;
    struct dx_pps p;
    const int64_t real0 = 1700000000 * S - 1234567; /* the host is late by 1.2 ms */

    (void)state;
    dx_pps_init(&p);
    dx_pps_state(&p, 0, &s);
    assert_false(s.is_locked);
    for (int64_t k = 0; k < 40; k++) {
        int64_t noise = k % 2 ? 700 : -700, fast = k * 20000; /* 20 ppm */

        dx_pps_pulse(&p, (uint64_t)(5 * S + k * S + fast + noise),
                     (uint64_t)(real0 + k * S + noise));
        if (k == 20) /* false ones */
            dx_pps_pulse(&p, (uint64_t)(5 * S + k * S + S / 3), (uint64_t)(real0 + k * S + S / 3));
    }
    dx_pps_state(&p, (uint64_t)(45 * S), &s);
    assert_true(s.is_locked);
    assert_true(s.offset_ns <= -1233867 && s.offset_ns >= -1235267);
    assert_true(s.jitter_ns <= 1400);
    assert_true(s.rate_ppb >= 19800 && s.rate_ppb <= 20200);
    assert_int_equal(p.n_bad, 1);
    dx_pps_state(&p, (uint64_t)(60 * S), &s);
    assert_false(s.is_locked); /* the receiver has lost it */
    dx_pps_pulse(&p, (uint64_t)(61 * S), (uint64_t)(real0 + 61 * S));
    dx_pps_state(&p, (uint64_t)(61 * S), &s);
    assert_false(s.is_locked); /* begins anew */
}

/* The first pulse was false: the true ones win. */
static void a_false_start_is_overcome(void **state)
{
    struct dx_pps_state s;
    struct dx_pps p;

    (void)state;
    dx_pps_init(&p);
    dx_pps_pulse(&p, 300 * MS, 300 * MS);
    for (int64_t k = 1; k < 6; k++)
        dx_pps_pulse(&p, (uint64_t)(k * S), (uint64_t)(k * S));
    dx_pps_state(&p, (uint64_t)(6 * S), &s);
    assert_true(s.is_locked);
    assert_int_equal(s.offset_ns, 0);
    assert_int_equal(s.rate_ppb, 0);
}

/* ---- in a rig
 * ----------------------------------------------------------------------------------- */

static char lines[3][16] = {"gpiochip0:1", "gpiochip0:2", "gpiochip0:3"};

/* A millisecond later. */
static const struct dx_rig_status *await(struct dx_rig *rig, struct dx_rig_status *status)
{
    poll(NULL, 0, 1);
    dx_rig_tell(rig, status);
    return status;
}

static void a_rig_stamps_frames(void **state)
{
    const struct dx_rig_config config = {
        .trigger_in = {.line = lines[0], .max_delay_ms = 200, .min_gap_us = 100}};
    struct dx_gpio_script *script;
    struct dx_rig_status status;
    struct dx_rig *rig;
    uint64_t edge_ns, t;
    char text[96];

    (void)state;
    assert_int_equal(dx_gpio_script_new(&script, NULL, 0, NULL), 0);
    assert_int_equal(dx_rig_open_on(&rig, &config, dx_gpio_script_bank(script), NULL), 0);
    assert_null(dx_rig_interlock(rig));
    while (!dx_gpio_script_is_open(script))
        poll(NULL, 0, 1);
    dx_rig_run(rig, true);
    t = dx_clock_ns();
    for (uint64_t k = 0; k < 5; k++) {
        dx_gpio_script_set_level(script, 0, true, t + k * PERIOD);
        dx_gpio_script_set_level(script, 0, false, t + k * PERIOD + 50000); /* 50 us: no edge */
        while (await(rig, &status)->n_edges < k + 1)
            ;
        assert_true(dx_rig_frame(rig, t + k * PERIOD + 9 * MS, 0, &edge_ns));
        assert_int_equal(edge_ns, t + k * PERIOD);
    }
    dx_rig_tell(rig, &status);
    assert_int_equal(status.n_pairs, 5);
    dx_rig_trouble(rig, text, sizeof(text));
    assert_string_equal(text, "");
    for (uint64_t k = 0; k < 9; k++)
        assert_false(dx_rig_frame(rig, t + (9 + k) * PERIOD, 0, &edge_ns));
    dx_rig_trouble(rig, text, sizeof(text));
    assert_string_equal(text, "frames come without edges of the trigger");
    dx_rig_close(rig);
    dx_gpio_script_free(script);
}

static void a_rig_triggers(void **state)
{
    const struct dx_rig_config config = {
        .trigger_out = {.line = lines[0], .hz = 1000, .pulse_us = 200}, .pps = {.line = lines[1]}};
    struct dx_gpio_script *script;
    struct dx_rig_status status;
    struct dx_rig *rig;

    (void)state;
    assert_int_equal(dx_gpio_script_new(&script, NULL, 0, NULL), 0);
    assert_int_equal(dx_rig_open_on(&rig, &config, dx_gpio_script_bank(script), NULL), 0);
    while (!dx_gpio_script_is_open(script))
        poll(NULL, 0, 1);
    dx_rig_tell(rig, &status);
    assert_int_equal(status.n_triggers, 0); /* not before it runs */
    dx_rig_run(rig, true);
    while (await(rig, &status)->n_triggers < 10)
        ;
    assert_true(dx_gpio_script_n_sets(script, 0) >= 19);
    for (uint64_t k = 0, t = dx_clock_ns() - 9 * (uint64_t)S; k < 9; k++) {
        dx_gpio_script_set_level(script, 1, true, t + k * (uint64_t)S);
        dx_gpio_script_set_level(script, 1, false, t + k * (uint64_t)S + 100 * MS);
    }
    while (!await(rig, &status)->is_pps_locked)
        ;
    assert_true(status.pps_offset_ns >= -S / 2 && status.pps_offset_ns <= S / 2);
    dx_rig_close(rig);
    assert_false(dx_gpio_script_level(script, 0));
    dx_gpio_script_free(script);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pairs_in_order),
        cmocka_unit_test(lost_frames_take_their_edges),
        cmocka_unit_test(lost_edges_leave_a_frame_without),
        cmocka_unit_test(never_takes_anothers),
        cmocka_unit_test(forgets_what_no_frame_takes),
        cmocka_unit_test(leaves_glitches_out),
        cmocka_unit_test(measures_the_second),
        cmocka_unit_test(a_false_start_is_overcome),
        cmocka_unit_test(a_rig_stamps_frames),
        cmocka_unit_test(a_rig_triggers),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
