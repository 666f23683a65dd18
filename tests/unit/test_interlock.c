/*
 * The interlock: its rule, and a rig that drops the laser by it, on lines of a script; what is
 * refused as unsafe; the LED.
 */
#include "drivers/gpio/gpio_script.h"
#include "drivers/gpio/interlock_guard.h"
#include "drivers/gpio/led.h"
#include "drivers/gpio/line_thread.h"
#include "drivers/monotonic.h"
#include "drivers/rig.h"

#include <errno.h>
#include <poll.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#define S 1000000000u

/* ---- the rule
 * ----------------------------------------------------------------------------------- */

static void opens_at_once_and_closes_later(void **state)
{
    struct dx_interlock_guard g;

    (void)state;
    dx_interlock_guard_init(&g, 500, 1000);
    assert_true(g.is_open);
    assert_int_equal(dx_interlock_guard_due(&g), UINT64_MAX);
    assert_false(dx_interlock_guard_contact(&g, true, 1000));
    assert_int_equal(dx_interlock_guard_due(&g), 1500);
    assert_false(dx_interlock_guard_contact(&g, true, 1499));
    assert_true(dx_interlock_guard_contact(&g, true, 1500));
    assert_false(g.is_open);
    assert_int_equal(g.since_ns, 1500);
    assert_int_equal(dx_interlock_guard_due(&g), UINT64_MAX);
    assert_true(dx_interlock_guard_contact(&g, false, 1600));
    assert_true(g.is_open);
    assert_int_equal(g.n_openings, 1);
    assert_false(dx_interlock_guard_contact(&g, false, 1700));
    assert_int_equal(g.since_ns, 1600);
    /* it chatters: the time begins anew with each break */
    for (uint64_t t = 2000; t < 3000; t += 100) {
        dx_interlock_guard_contact(&g, true, t);
        assert_false(dx_interlock_guard_break(&g, t + 50));
    }
    assert_false(dx_interlock_guard_contact(&g, true, 3000));
    assert_false(dx_interlock_guard_contact(&g, true, 3499));
    assert_true(dx_interlock_guard_contact(&g, true, 3500));
    assert_int_equal(g.n_openings, 1);
}

static void a_break_between_two_looks_counts(void **state)
{
    struct dx_interlock_guard g;

    (void)state;
    dx_interlock_guard_init(&g, 0, 0);
    assert_true(dx_interlock_guard_contact(&g, true, 1));
    assert_true(dx_interlock_guard_break(&g, 2));
    assert_true(g.is_open);
    assert_int_equal(g.cause, DX_GUARD_CONTACT);
    assert_true(dx_interlock_guard_contact(&g, true, 3));
    assert_int_equal(g.n_openings, 1);
    assert_true(dx_interlock_guard_fault(&g, 4));
    assert_int_equal(g.cause, DX_GUARD_FAULT);
    assert_int_equal(g.n_openings, 2);
}

/* ---- a rig
 * -------------------------------------------------------------------------------------- */

static char chip[4][16] = {"gpiochip0:1", "gpiochip0:2", "gpiochip0:3", "gpiochip0:4"};
enum { INTERLOCK, LASER, LED }; /* without a trigger between */

static struct dx_rig_config config;
static struct dx_gpio_script *script;
static struct dx_rig *rig;

static void open_it(void)
{
    struct dx_err err = {""};

    assert_int_equal(dx_rig_open_on(&rig, &config, dx_gpio_script_bank(script), &err), 0);
}

static int setup(void **state)
{
    (void)state;
    config = (struct dx_rig_config){
        .interlock = {.line = chip[0], .active_low = true, .bias = DX_GPIO_PULL_DOWN},
        .laser = {.line = chip[1]},
        .led = {.line = chip[2]},
    };
    assert_int_equal(dx_gpio_script_new(&script, NULL, 0, NULL), 0);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    dx_rig_close(rig);
    rig = NULL;
    dx_gpio_script_free(script);
    return 0;
}

/* Until the rig's thread has done it; the test's runner ends what never comes. */
static void await_level(uint32_t line, bool level)
{
    while (dx_gpio_script_level(script, line) != level)
        poll(NULL, 0, 1);
}

static struct dx_interlock_state await_open(bool is_open)
{
    struct dx_interlock_state s;

    while (dx_interlock_is_open(dx_rig_interlock(rig), &s) != is_open)
        poll(NULL, 0, 1);
    return s;
}

/* The line's logical level: stop. */
static void stop(bool is_stop)
{
    dx_gpio_script_set_level(script, INTERLOCK, is_stop, dx_clock_ns());
}

static void drops_the_laser(void **state)
{
    struct dx_interlock_state s;
    struct dx_rig_status status;
    char text[96];

    (void)state;
    open_it();
    await_open(false);
    dx_rig_tell(rig, &status);
    assert_true(status.has_lines);
    assert_false(status.is_laser_on); /* nothing runs yet */
    assert_false(dx_gpio_script_level(script, LASER));
    dx_rig_run(rig, true);
    await_level(LASER, true);
    dx_rig_trouble(rig, text, sizeof(text));
    assert_string_equal(text, "");

    stop(true);
    await_level(LASER, false);
    s = await_open(true);
    assert_int_equal(s.n_openings, 1);
    assert_string_equal(s.text, "interlock open: laser off");
    dx_rig_trouble(rig, text, sizeof(text));
    assert_string_equal(text, s.text);

    stop(false);
    await_level(LASER, true);
    s = await_open(false);
    assert_int_equal(s.n_openings, 1);
    assert_string_equal(s.text, "");

    /* open and closed again before anybody looked: it was open */
    dx_gpio_script_set_level(script, INTERLOCK, true, dx_clock_ns());
    dx_gpio_script_set_level(script, INTERLOCK, false, dx_clock_ns());
    while (await_open(false).n_openings < 2)
        poll(NULL, 0, 1);
    await_level(LASER, true);
    dx_rig_run(rig, false);
    await_level(LASER, false);
}

/* Its edge was lost: its level is looked at all the same. */
static void sees_a_lost_edge(void **state)
{
    (void)state;
    open_it();
    dx_rig_run(rig, true);
    await_level(LASER, true);
    dx_gpio_script_slip(script, INTERLOCK, true);
    await_level(LASER, false);
}

/* Events of the trigger were lost in the queue that it shares with the interlock. */
static void what_was_lost_may_be_a_stop(void **state)
{
    const struct dx_gpio_script_faults faults = {.lose_at = 1, .n_lose = 1};
    struct dx_rig_status status;

    (void)state;
    dx_gpio_script_free(script);
    assert_int_equal(dx_gpio_script_new(&script, NULL, 0, &faults), 0);
    config.trigger_in.line = chip[3];
    open_it();
    await_open(false);
    for (uint64_t k = 0; k < 3; k++) { /* the second is lost, the third tells */
        dx_gpio_script_set_level(script, 2, true, dx_clock_ns());
        dx_gpio_script_set_level(script, 2, false, dx_clock_ns());
    }
    do {
        poll(NULL, 0, 1);
        dx_rig_tell(rig, &status);
    } while (status.n_edges < 2);
    assert_int_equal(status.n_openings, 1);
    await_open(false);
}

static void stays_off_until_rearmed(void **state)
{
    struct dx_interlock_state s;

    (void)state;
    config.interlock.rearm_ms = 3600000;
    open_it();
    dx_rig_run(rig, true);
    do
        s = await_open(true);
    while (strstr(s.text, "not read yet") || !strstr(s.text, "closed"));
    assert_string_equal(s.text, "interlock closed again, laser still off");
    assert_false(dx_gpio_script_level(script, LASER));
    assert_int_equal(dx_gpio_script_n_sets(script, LASER), 0);
}

/* The laser goes off with the rig, however it ends. */
static void ends_dark(void **state)
{
    (void)state;
    open_it();
    dx_rig_run(rig, true);
    dx_rig_show(rig, DX_RIG_LIVE);
    await_level(LASER, true);
    await_level(LED, true);
    dx_rig_close(rig);
    rig = NULL;
    assert_false(dx_gpio_script_level(script, LASER));
    assert_false(dx_gpio_script_level(script, LED));
    assert_false(dx_gpio_script_is_open(script));
}

/* A reader that does not come back may still say that it runs. */
static void ends_for_good(void **state)
{
    struct dx_rig_status status;

    (void)state;
    open_it();
    dx_rig_run(rig, true);
    await_level(LASER, true);
    dx_rig_end(rig);
    await_level(LASER, false);
    dx_rig_run(rig, true);
    stop(true);
    await_open(true);
    stop(false);
    await_open(false); /* the rig's thread has been around */
    dx_rig_tell(rig, &status);
    assert_false(status.is_laser_on);
    assert_false(dx_gpio_script_level(script, LASER));
}

static void lines_that_go_open_it(void **state)
{
    struct dx_interlock_state s;
    char text[96];

    (void)state;
    open_it();
    dx_rig_run(rig, true);
    await_level(LASER, true);
    dx_gpio_script_unplug(script, true);
    s = await_open(true);
    assert_string_equal(s.text, "interlock: gpio: the chip is gone");
    assert_int_equal(s.n_openings, 1);
    while (dx_gpio_script_is_open(script)) /* given back */
        poll(NULL, 0, 1);
    dx_rig_trouble(rig, text, sizeof(text));
    assert_non_null(strstr(text, "interlock: gpio"));
}

/* Lines that are in use are no error of the stream, but nothing is armed without them. */
static void lines_that_are_not_there_open_it(void **state)
{
    struct dx_gpio_script_faults faults = {.refuse = -EBUSY};
    struct dx_interlock_state s;

    (void)state;
    dx_gpio_script_free(script);
    assert_int_equal(dx_gpio_script_new(&script, NULL, 0, &faults), 0);
    open_it();
    dx_rig_run(rig, true);
    do
        s = await_open(true);
    while (!strstr(s.text, "gpiochip0:1"));
    assert_false(dx_gpio_script_level(script, LASER));
}

/* A square wave while the laser may be on, for hardware that drops it when the beats end. */
static void beats(void **state)
{
    (void)state;
    config.laser.heartbeat_hz = 500;
    open_it();
    dx_rig_run(rig, true);
    for (int k = 0; k < 5; k++) {
        await_level(LASER, true);
        await_level(LASER, false);
    }
    stop(true);
    await_open(true);
    await_level(LASER, false);
    for (uint64_t n = dx_gpio_script_n_sets(script, LASER), t = dx_clock_ns();
         dx_clock_ns() < t + 20000000;)
        assert_int_equal(dx_gpio_script_n_sets(script, LASER), n);
}

static void refuses_what_is_unsafe(void **state)
{
    static char bad[] = "not a line";
    const char *key;

    (void)state;
    assert_null(dx_rig_check(&config, &key));
    assert_true(dx_rig_is_wanted(&config));
    config.interlock.bias = DX_GPIO_PULL_UP;
    assert_non_null(strstr(dx_rig_check(&config, &key), "broken wire"));
    assert_string_equal(key, "interlock.bias");
    config.interlock.active_low = false;
    assert_null(dx_rig_check(&config, &key));
    config.interlock.bias = DX_GPIO_PULL_DOWN;
    assert_non_null(strstr(dx_rig_check(&config, &key), "broken wire"));
    config.interlock.bias = DX_GPIO_AS_IS;
    config.interlock.line = NULL;
    assert_non_null(dx_rig_check(&config, &key));
    assert_string_equal(key, "laser.line");
    config.laser.line = NULL;
    assert_null(dx_rig_check(&config, &key));
    config.led.line = bad;
    assert_non_null(dx_rig_check(&config, &key));
    assert_string_equal(key, "led.line");
    config = (struct dx_rig_config){.trigger_out = {.line = chip[3], .hz = 100, .pulse_us = 10000}};
    assert_non_null(dx_rig_check(&config, &key));
    assert_string_equal(key, "trigger_out.pulse_us");
    config.trigger_out.pulse_us = 9000;
    assert_null(dx_rig_check(&config, &key));
    config.trigger_out.hz = 0;
    assert_non_null(dx_rig_check(&config, &key));
    config = (struct dx_rig_config){.laser = {.heartbeat_hz = -1}};
    assert_false(dx_rig_is_wanted(&config));
    assert_non_null(dx_rig_check(&config, &key));
}

/* ---- the LED
 * ------------------------------------------------------------------------------------ */

/* How often it lights up, and for how many milliseconds, in so many seconds. */
static void expect_blinks(enum dx_rig_show show, uint64_t seconds, int n_blinks, uint64_t lit_ms)
{
    uint64_t t = 0, until, lit_ns = 0;
    bool was = false;
    int n = 0;

    while (t < seconds * S) {
        bool is_lit = dx_led_is_lit(show, t, &until);

        if (until > seconds * S)
            until = seconds * S;
        assert_true(until > t);
        lit_ns += is_lit ? until - t : 0;
        n += is_lit && !was;
        was = is_lit;
        t = until;
    }
    assert_int_equal(n, n_blinks);
    assert_int_equal(lit_ns / 1000000, lit_ms);
}

static void states_look_different(void **state)
{
    (void)state;
    expect_blinks(DX_RIG_OFF, 8, 0, 0);
    expect_blinks(DX_RIG_WAITING, 8, 4, 1000);
    expect_blinks(DX_RIG_LIVE, 8, 1, 8000);
    expect_blinks(DX_RIG_TROUBLE, 8, 16, 4000);
    expect_blinks(DX_RIG_INTERLOCK, 8, 10, 2000);
}

static void the_interlock_shows_itself(void **state)
{
    (void)state;
    open_it();
    dx_rig_show(rig, DX_RIG_LIVE);
    await_open(false);
    await_level(LED, true);
    stop(true);
    await_level(LED, false); /* it blinks */
    await_level(LED, true);
    await_level(LED, false);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(opens_at_once_and_closes_later),
        cmocka_unit_test(a_break_between_two_looks_counts),
        cmocka_unit_test_setup_teardown(drops_the_laser, setup, teardown),
        cmocka_unit_test_setup_teardown(sees_a_lost_edge, setup, teardown),
        cmocka_unit_test_setup_teardown(what_was_lost_may_be_a_stop, setup, teardown),
        cmocka_unit_test_setup_teardown(stays_off_until_rearmed, setup, teardown),
        cmocka_unit_test_setup_teardown(ends_dark, setup, teardown),
        cmocka_unit_test_setup_teardown(ends_for_good, setup, teardown),
        cmocka_unit_test_setup_teardown(lines_that_go_open_it, setup, teardown),
        cmocka_unit_test_setup_teardown(lines_that_are_not_there_open_it, setup, teardown),
        cmocka_unit_test_setup_teardown(beats, setup, teardown),
        cmocka_unit_test_setup_teardown(refuses_what_is_unsafe, setup, teardown),
        cmocka_unit_test(states_look_different),
        cmocka_unit_test_setup_teardown(the_interlock_shows_itself, setup, teardown),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
