/*
 * GPIO lines about a device that lives: the laser while it is open, the interlock's silence that is
 * no fault, stamps of triggers. The device is fake_driver.h's, the lines are a script's.
 */
#include "fake_driver.h"

#include "daemon/clock.h"
#include "daemon/log.h"
#include "daemon/reader_device.h"
#include "daemon/reader_rig.h"
#include "drivers/gpio/gpio_script.h"

#define SECOND 1000000000ull

enum { INTERLOCK, LASER };

static char lines[2][16] = {"gpiochip0:1", "gpiochip0:2"};
static struct dx_rig_config config;
static struct dx_gpio_script *script;
static struct dx_rig *rig;
static struct dx_mailbox *mailbox;
static struct dx_reader_device *reader;
static const struct dx_interlock *guarded;

static void on_mail(void *ctx)
{
    (void)ctx;
}

static void guard(struct dx_device *dev, const struct dx_interlock *interlock)
{
    (void)dev;
    guarded = interlock;
}

static struct dx_driver driver;

static int setup(void **state)
{
    (void)state;
    dx_log_set_level(-1);
    config = (struct dx_rig_config){
        .interlock = {.line = lines[0], .active_low = true, .bias = DX_GPIO_PULL_DOWN},
        .laser = {.line = lines[1]},
    };
    driver = fake_driver;
    driver.guard = guard;
    assert_int_equal(dx_gpio_script_new(&script, NULL, 0, NULL), 0);
    assert_int_equal(dx_rig_open_on(&rig, &config, dx_gpio_script_bank(script), NULL), 0);
    assert_int_equal(dx_mailbox_new(&mailbox, false, on_mail, NULL), 0);
    assert_int_equal(dx_reader_device_new(&reader, "t", &driver, NULL, mailbox, NULL), 0);
    dx_reader_device_rig(reader, rig);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    dx_reader_device_close(reader);
    dx_reader_device_free(reader);
    dx_mailbox_free(mailbox);
    dx_rig_close(rig);
    dx_gpio_script_free(script);
    fake = (struct fake_world){0};
    return 0;
}

static struct dx_reader_device_status status(void)
{
    struct dx_reader_device_status s;

    dx_reader_device_status(reader, &s);
    return s;
}

/* Reads on until the device is so. */
static void read_until(enum dx_life_state state)
{
    struct dx_block block;

    while (status().state != state)
        dx_reader_device_read(reader, &block);
}

static void await_laser(bool level)
{
    while (dx_gpio_script_level(script, LASER) != level)
        poll(NULL, 0, 1);
}

static void stop(bool is_stop)
{
    dx_gpio_script_set_level(script, INTERLOCK, is_stop, dx_clock_ns());
}

static void the_laser_is_on_while_it_is_open(void **state)
{
    (void)state;
    read_until(DX_LIFE_ABSENT);
    assert_false(dx_gpio_script_level(script, LASER));
    assert_int_equal(dx_gpio_script_n_sets(script, LASER), 0);
    fake.present = true;
    dx_reader_device_poke(reader);
    read_until(DX_LIFE_STREAMING);
    await_laser(true);
    assert_ptr_equal(guarded, dx_rig_interlock(rig));
    fake.present = false;
    read_until(DX_LIFE_GONE);
    await_laser(false);
}

static void an_open_interlock_is_no_fault(void **state)
{
    struct dx_reader_device_status s;
    char text[96];

    (void)state;
    fake.present = true;
    read_until(DX_LIFE_STREAMING);
    await_laser(true);
    stop(true);
    fake.silent = true; /* as a scanner without its laser */
    await_laser(false);
    read_until(DX_LIFE_STALLED);
    assert_string_equal(status().reason, "interlock open: laser off");
    assert_true(dx_reader_rig_holds(rig, dx_clock_ns() + 3600u * SECOND, text));
    assert_string_equal(text, "interlock open: laser off");
    s = status();
    assert_int_equal(s.state, DX_LIFE_STALLED);
    assert_int_equal(s.n_opens, 1);
    assert_int_equal(s.n_faults, 0);
    stop(false);
    await_laser(true);
    assert_true(dx_reader_rig_holds(rig, dx_clock_ns(), text)); /* it has to begin again */
    assert_string_equal(text, "");
    assert_false(dx_reader_rig_holds(rig, dx_clock_ns() + 3600u * SECOND, text));
    fake.silent = false;
    read_until(DX_LIFE_STREAMING);
    assert_int_equal(status().n_opens, 1);
}

static uint64_t n_lost;

static void lossy_health(const struct dx_device *dev, struct dx_device_health *out)
{
    (void)dev;
    out->n_lost = n_lost;
}

static void triggers_stamp_blocks(void **state)
{
    const struct dx_rig_config trigger = {.trigger_in = {.line = lines[0], .max_delay_ms = 500}};
    const struct dx_driver lossy = {.name = "lossy", .health = lossy_health};
    struct dx_gpio_script *edges;
    struct dx_rig *stamps;
    struct dx_rig_status s;
    uint64_t t, lost = 0, period = 20000000;

    (void)state;
    assert_int_equal(dx_gpio_script_new(&edges, NULL, 0, NULL), 0);
    assert_int_equal(dx_rig_open_on(&stamps, &trigger, dx_gpio_script_bank(edges), NULL), 0);
    while (!dx_gpio_script_is_open(edges))
        poll(NULL, 0, 1);
    dx_reader_rig_open(stamps, &lossy, NULL);
    t = dx_clock_ns();
    for (uint64_t k = 0; k < 10; k++) {
        struct dx_block block = {.stamp = {t + k * period + 7000000, 123, DX_CLOCK_DEVICE}};

        dx_gpio_script_set_level(edges, 0, true, t + k * period);
        dx_gpio_script_set_level(edges, 0, false, t + k * period + 1000);
        do {
            poll(NULL, 0, 1);
            dx_rig_tell(stamps, &s);
        } while (s.n_edges < k + 1);
        if (k == 4 || k == 5) { /* these frames never come */
            n_lost++;
            continue;
        }
        dx_reader_rig_stamp(stamps, &lossy, NULL, &lost, &block);
        assert_int_equal(block.stamp.device_ns, t + k * period);
        assert_int_equal(block.stamp.clock_id, DX_CLOCK_MONOTONIC);
    }
    dx_rig_tell(stamps, &s);
    assert_int_equal(s.n_pairs, 8);
    assert_int_equal(s.n_resyncs, 0);
    dx_rig_close(stamps);
    dx_gpio_script_free(edges);
}

static void without_lines_nothing_happens(void **state)
{
    struct dx_block block = {.stamp = {1, 2, DX_CLOCK_DEVICE}};
    struct dx_device_health health = {.trouble = "dust"};
    uint64_t lost = 0;
    char text[96];

    (void)state;
    dx_reader_rig_open(NULL, &driver, NULL);
    dx_reader_rig_stamp(NULL, &driver, NULL, &lost, &block);
    dx_reader_rig_trouble(NULL, &health);
    dx_reader_rig_show(NULL, DX_LIFE_STREAMING, false);
    assert_false(dx_reader_rig_holds(NULL, 5, text));
    dx_reader_rig_close(NULL);
    assert_int_equal(block.stamp.device_ns, 2);
    assert_string_equal(health.trouble, "dust");
    assert_string_equal(text, "");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(the_laser_is_on_while_it_is_open, setup, teardown),
        cmocka_unit_test_setup_teardown(an_open_interlock_is_no_fault, setup, teardown),
        cmocka_unit_test(triggers_stamp_blocks),
        cmocka_unit_test(without_lines_nothing_happens),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
