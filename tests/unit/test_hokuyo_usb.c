/*
 * The driver over USB: the simulated scanner as a device of umockdev (mock_usb.h), under the real
 * libusb. In real time, as the mock answers when it is asked.
 */
#include "drivers/hokuyo/hokuyo.h"
#include "drivers/replay.h"
#include "tests/hil/scip_device.h"
#include "tests/unit/mock_usb.h"

#include <errno.h>
#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>

/* CDC-ACM as a scanner has it: communication interface 0, data interface 1. */
static const uint8_t descriptors[] = {18, 1, 0,    2, 2,  0,  0,  64, 0xd1, 0x15, 0, 0,    0,   1,
                                      1,  2, 0,    1, 9,  2,  48, 0,  2,    1,    0, 0x80, 250, /**/
                                      9,  4, 0,    0, 1,  2,  2,  1,  0,                        /**/
                                      7,  5, 0x83, 3, 8,  0,  4,                                /**/
                                      9,  4, 1,    0, 2,  10, 0,  0,  0,                        /**/
                                      7,  5, 0x81, 2, 64, 0,  0,                                /**/
                                      7,  5, 2,    2, 64, 0,  0};
_Static_assert(sizeof(descriptors) == 18 + 48, "configuration's total length");

static struct scip_sim sim;
static struct mock_usb *mock;
static bool refuses; /* the requests of CDC-ACM */
static int n_requests;
static uint32_t columns; /* of a turn */

static int on_control(void *ctx, const uint8_t request[8], uint8_t *bytes, int len)
{
    static const char *const texts[] = {"Hokuyo Automatic Co, Ltd.", "URG-Series USB Driver"};

    (void)ctx;
    if (request[0] == 0x80)
        return mock_usb_string(request, bytes, len, texts, 2);
    n_requests++;
    return refuses || request[0] != 0x21 ? MOCK_USB_STALL : len;
}

static int on_in(void *ctx, uint8_t endpoint, uint8_t *bytes, int len)
{
    size_t n;

    (void)ctx;
    scip_sim_tick(&sim, dx_pace_now());
    n = sim.out_len < (size_t)len ? sim.out_len : (size_t)len;
    if (endpoint != 0x81 || n == 0)
        return MOCK_USB_HOLD;
    memcpy(bytes, sim.out, n);
    sim.out_len -= n;
    memmove(sim.out, sim.out + n, sim.out_len);
    return (int)n;
}

static int on_out(void *ctx, uint8_t endpoint, const uint8_t *bytes, int len)
{
    (void)ctx;
    if (endpoint != 2)
        return MOCK_USB_STALL;
    scip_sim_feed(&sim, bytes, (size_t)len, dx_pace_now());
    return len;
}

/* The scanner is asked in the testbed's thread, under the mock's lock. */
static enum scip_sim_state state_of_sim(void)
{
    enum scip_sim_state state;

    mock_usb_lock(mock);
    state = sim.state;
    mock_usb_unlock(mock);
    return state;
}

static void set_faults(struct scip_faults faults)
{
    mock_usb_lock(mock);
    sim.faults = faults;
    mock_usb_unlock(mock);
}

static void set_refuses(bool on)
{
    mock_usb_lock(mock);
    refuses = on;
    mock_usb_unlock(mock);
}

static int count_requests(void)
{
    int n;

    mock_usb_lock(mock);
    n = n_requests;
    mock_usb_unlock(mock);
    return n;
}

static int setup(void **state)
{
    (void)state;
    refuses = false;
    columns = 0;
    n_requests = 0;
    scip_sim_init(&sim, &scip_models[2], dx_pace_now());
    mock = mock_usb_new(&(struct mock_usb_device){descriptors, sizeof(descriptors), NULL,
                                                  on_control, on_in, on_out, false});
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    mock_usb_free(mock);
    return 0;
}

static struct dx_device *start(const char *port, const char *serial)
{
    const struct dx_hokuyo_config c = {.port = (char *)port,
                                       .serial = (char *)serial,
                                       .first_step = 500,
                                       .last_step = 580,
                                       .cluster = 1,
                                       .stage = {.angle = {.rpm = 10}, .columns = columns}};
    struct dx_device *dev = NULL;
    struct dx_err err = {""};

    assert_int_equal(dx_hokuyo_driver.open(&dev, &c, &err), 0);
    assert_int_equal(dx_hokuyo_driver.start(dev, &err), 0);
    return dev;
}

/* The next block, or why there is none. */
static int next(struct dx_device *dev, struct dx_block *block, struct dx_err *err)
{
    int r;

    do
        r = dx_hokuyo_driver.read(dev, block, err);
    while (r == DX_DRIVER_E_AGAIN);
    return r;
}

static void streams(void **state)
{
    (void)state;
    for (int round = 0; round < 2; round++) {
        struct dx_device_health health;
        struct dx_device *dev;
        struct dx_block block;
        struct dx_err err = {""};

        set_refuses(round == 1); /* a scanner needs none of it */
        dev = start("1-1", "H0614967");
        for (uint64_t k = 0; k < 5; k++) {
            assert_int_equal(next(dev, &block, &err), 0);
            assert_int_equal(block.number, k);
            assert_int_equal(block.first, k == 0);
        }
        assert_int_equal(count_requests(), 2 * (round + 1));
        dx_hokuyo_driver.health(dev, &health);
        assert_string_equal(health.serial, "H0614967");
        assert_string_equal(health.place, "usb 1-1");
        assert_int_equal(health.n_damaged + health.n_lost, 0);
        dx_hokuyo_driver.stop(dev);
        dx_hokuyo_driver.close(dev);
        assert_int_equal(state_of_sim(), SIM_IDLE);
        assert_int_equal(mock_usb_n_claimed(mock), 0);
        assert_int_equal(mock_usb_n_queued(mock), 0);
    }
}

/* A mesh that cannot come of it is told, before anybody wonders. */
static void tells_of_empty_columns(void **state)
{
    struct dx_device_health health;
    struct dx_device *dev;
    struct dx_block block;
    struct dx_err err = {""};

    (void)state;
    columns = 4000; /* 240 scans a turn */
    dev = start("", "");
    for (unsigned k = 0; k < 10; k++)
        assert_int_equal(next(dev, &block, &err), 0);
    dx_hokuyo_driver.health(dev, &health);
    assert_non_null(strstr(health.trouble, "too few scans a turn for 4000 columns"));
    dx_hokuyo_driver.stop(dev);
    dx_hokuyo_driver.close(dev);
}

static bool contact_is_open;

static void interlock_state(const struct dx_interlock *interlock, struct dx_interlock_state *out)
{
    (void)interlock;
    out->is_open = contact_is_open;
}

/* The laser is off while the interlock is open, and the scanner measures again when it is closed.
 * What was counted before stays. */
static void obeys_the_interlock(void **state)
{
    static const struct dx_interlock interlock = {interlock_state};
    struct dx_device *dev = start("", "");
    struct dx_device_health before, health;
    struct dx_block block;
    struct dx_err err = {""};

    (void)state;
    contact_is_open = false;
    dx_hokuyo_driver.guard(dev, &interlock);
    set_faults((struct scip_faults){.bad_sum_every = 2});
    assert_int_equal(next(dev, &block, &err), 0);
    assert_int_equal(next(dev, &block, &err), 0);
    set_faults((struct scip_faults){.bad_sum_every = 0});
    dx_hokuyo_driver.health(dev, &before);
    assert_true(before.n_damaged > 0);
    for (int round = 0; round < 2; round++) {
        assert_int_equal(state_of_sim(), SIM_MULTI);
        contact_is_open = true;
        assert_int_equal(dx_hokuyo_driver.read(dev, &block, &err), DX_DRIVER_E_AGAIN);
        assert_int_equal(state_of_sim(), SIM_IDLE);
        assert_int_equal(dx_hokuyo_driver.read(dev, &block, &err), DX_DRIVER_E_AGAIN);
        assert_int_equal(state_of_sim(), SIM_IDLE);
        contact_is_open = false;
        assert_int_equal(next(dev, &block, &err), 0);
    }
    dx_hokuyo_driver.health(dev, &health);
    assert_true(health.n_damaged >= before.n_damaged && health.n_lost >= before.n_lost);
    contact_is_open = true; /* unplugged in the dark */
    assert_int_equal(dx_hokuyo_driver.read(dev, &block, &err), DX_DRIVER_E_AGAIN);
    mock_usb_unplug(mock);
    assert_int_equal(next(dev, &block, &err), DX_DRIVER_E_GONE);
    dx_hokuyo_driver.stop(dev);
    dx_hokuyo_driver.close(dev);
}

static void refuses_another_serial(void **state)
{
    struct dx_device *dev = start("", "H0000001");
    struct dx_block block;
    struct dx_err err = {""};

    (void)state;
    assert_int_equal(next(dev, &block, &err), -ENXIO); /* there, and not ours */
    assert_string_equal(err.text, "usb 1-1: serial number is 'H0614967', expected 'H0000001'");
    dx_hokuyo_driver.stop(dev);
    dx_hokuyo_driver.close(dev);
    set_faults((struct scip_faults){.no_serial = true});
    dev = start("", "H0614967");
    assert_int_equal(next(dev, &block, &err), -ENXIO);
    assert_string_equal(err.text,
                        "usb 1-1: the scanner tells no serial number, expected 'H0614967'");
    dx_hokuyo_driver.stop(dev);
    dx_hokuyo_driver.close(dev);
}

static void is_unplugged(void **state)
{
    struct dx_device *dev = start("", "");
    struct dx_block block;
    struct dx_err err = {""};
    int r;

    (void)state;
    assert_int_equal(next(dev, &block, &err), 0);
    mock_usb_unplug(mock);
    do
        r = next(dev, &block, &err);
    while (r == 0); /* what had come before */
    assert_int_equal(r, DX_DRIVER_E_GONE);
    assert_non_null(strstr(err.text, "removed"));
    dx_hokuyo_driver.stop(dev);
    dx_hokuyo_driver.close(dev);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(streams, setup, teardown),
        cmocka_unit_test_setup_teardown(tells_of_empty_columns, setup, teardown),
        cmocka_unit_test_setup_teardown(obeys_the_interlock, setup, teardown),
        cmocka_unit_test_setup_teardown(refuses_another_serial, setup, teardown),
        cmocka_unit_test_setup_teardown(is_unplugged, setup, teardown),
    };

    (void)argc;
    mock_usb_wrap(argv);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
