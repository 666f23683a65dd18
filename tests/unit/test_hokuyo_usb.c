/*
 * The driver over USB: the simulated scanner as a device of umockdev (mock_usb.h), under the real
 * libusb. The monotonic clock is the test's: it goes on when a transfer is asked for and nothing is
 * there, so nothing waits, and a busy machine changes nothing.
 */
#include "drivers/hokuyo/hokuyo.h"
#include "drivers/monotonic.h"
#include "tests/hil/scip_device.h"
#include "tests/unit/mock_usb.h"

#include <errno.h>
#include <poll.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <string.h>
#include <time.h>
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

/* The second scanner, at port 1-2, is there when a test puts it there. */
static struct scip_sim sim, sim2;
static struct mock_usb *mock, *mock2;
static bool refuses; /* the requests of CDC-ACM */
static int n_requests;
static uint32_t columns; /* of a turn */

/* ---- the clock: by the linker's wraps (Makefile) ----------------------------------------------
 */

#define CALL_NS 1000    /* of asking what time it is */
#define IDLE_NS 1000000 /* of a transfer that stays queued */

int __real_clock_gettime(clockid_t id, struct timespec *t);
int __wrap_clock_gettime(clockid_t id, struct timespec *t);
int __real_poll(struct pollfd *fds, nfds_t n, int timeout_ms);
int __wrap_poll(struct pollfd *fds, nfds_t n, int timeout_ms);

static _Atomic uint64_t time_ns = UINT64_C(1000000000000);

int __wrap_clock_gettime(clockid_t id, struct timespec *t)
{
    uint64_t now;

    if (id != CLOCK_MONOTONIC)
        return __real_clock_gettime(id, t);
    now = atomic_fetch_add(&time_ns, CALL_NS);
    *t = (struct timespec){(time_t)(now / 1000000000), (long)(now % 1000000000)};
    return 0;
}

/* A nap; the mock's descriptors are always ready. */
int __wrap_poll(struct pollfd *fds, nfds_t n, int timeout_ms)
{
    if (n > 0)
        return __real_poll(fds, n, timeout_ms);
    atomic_fetch_add(&time_ns, (uint64_t)timeout_ms * 1000000);
    return 0;
}

/* ---- the scanners -----------------------------------------------------------------------------
 */

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
    struct scip_sim *s = ctx;
    size_t n;

    scip_sim_tick(s, dx_clock_ns());
    n = s->out_len < (size_t)len ? s->out_len : (size_t)len;
    if (endpoint != 0x81 || n == 0) {
        atomic_fetch_add(&time_ns, IDLE_NS);
        return MOCK_USB_HOLD;
    }
    memcpy(bytes, s->out, n);
    scip_sim_sent(s, n);
    return (int)n;
}

static int on_out(void *ctx, uint8_t endpoint, const uint8_t *bytes, int len)
{
    if (endpoint != 2)
        return MOCK_USB_STALL;
    scip_sim_feed(ctx, bytes, (size_t)len, dx_clock_ns());
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
    const struct mock_usb_device device = {.descriptors = descriptors,
                                           .descriptors_len = sizeof(descriptors),
                                           .ctx = &sim,
                                           .control = on_control,
                                           .in = on_in,
                                           .out = on_out};

    (void)state;
    refuses = false;
    columns = 0;
    n_requests = 0;
    scip_sim_init(&sim, &scip_models[2], dx_clock_ns());
    mock = mock_usb_new(&device);
    mock2 = NULL;
    return 0;
}

/* `usb_serial` NULL: USB tells none, as of all scanners so far. */
static void plug_second(const char *serial, const char *usb_serial)
{
    const struct mock_usb_device device = {.descriptors = descriptors,
                                           .descriptors_len = sizeof(descriptors),
                                           .ctx = &sim2,
                                           .control = on_control,
                                           .in = on_in,
                                           .out = on_out,
                                           .serial = usb_serial};

    scip_sim_init(&sim2, &scip_models[2], dx_clock_ns());
    sim2.serial = serial;
    mock2 = mock_usb_new_beside(mock, &device);
}

static int teardown(void **state)
{
    (void)state;
    if (mock2)
        mock_usb_free(mock2);
    mock_usb_free(mock);
    return 0;
}

/* Opens and reaches a scanner: 0, or why not. */
static int reach(struct dx_device **dev, const char *port, const char *serial, struct dx_err *err)
{
    const struct dx_hokuyo_config c = {.port = (char *)(uintptr_t)port,
                                       .serial = (char *)(uintptr_t)serial,
                                       .first_step = 500,
                                       .last_step = 580,
                                       .cluster = 1,
                                       .stage = {.angle = {.rpm = 10}, .columns = columns}};
    int r = dx_hokuyo_driver.open(dev, &c, err);

    if (r)
        return r;
    do
        r = dx_hokuyo_driver.connect(*dev, err);
    while (r == DX_DRIVER_E_AGAIN);
    if (r)
        dx_hokuyo_driver.close(*dev);
    return r;
}

static void stop(struct dx_device *dev)
{
    dx_hokuyo_driver.stop(dev);
    dx_hokuyo_driver.close(dev);
}

static struct dx_device *start(const char *port, const char *serial)
{
    struct dx_device *dev = NULL;
    struct dx_err err = {""};

    if (reach(&dev, port, serial, &err))
        fail_msg("%s", err.text);
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
        stop(dev);
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
    stop(dev);
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
    stop(dev);
}

/* At a port that is named, another one is a fault. */
static void refuses_another_serial(void **state)
{
    struct dx_device *dev = start("1-1", "H0000001");
    struct dx_block block;
    struct dx_err err = {""};

    (void)state;
    assert_int_equal(next(dev, &block, &err), -ENXIO); /* there, and not ours */
    assert_string_equal(err.text, "usb 1-1: serial number is 'H0614967', expected 'H0000001'");
    stop(dev);
    set_faults((struct scip_faults){.no_serial = true});
    dev = start("1-1", "H0614967");
    assert_int_equal(next(dev, &block, &err), -ENXIO);
    assert_string_equal(err.text,
                        "usb 1-1: the scanner tells no serial number, expected 'H0614967'");
    stop(dev);
}

static void expect_place(struct dx_device *dev, const char *serial, const char *place)
{
    struct dx_device_health health;
    struct dx_block block;
    struct dx_err err = {""};

    assert_int_equal(next(dev, &block, &err), 0);
    dx_hokuyo_driver.health(dev, &health);
    assert_string_equal(health.serial, serial);
    assert_string_equal(health.place, place);
}

/* Two of a kind, and two streams: each has its own, whichever is opened first. */
static void finds_each_its_own(void **state)
{
    struct dx_device *one, *two;
    struct dx_err err = {""};

    (void)state;
    plug_second("H0000002", NULL);
    for (int round = 0; round < 2; round++) {
        two = start("", round ? "H0614967" : "H0000002");
        one = start("", round ? "H0000002" : "H0614967");
        expect_place(two, round ? "H0614967" : "H0000002", round ? "usb 1-1" : "usb 1-2");
        expect_place(one, round ? "H0000002" : "H0614967", round ? "usb 1-2" : "usb 1-1");
        stop(one);
        stop(two);
        assert_int_equal(mock_usb_n_claimed(mock) + mock_usb_n_claimed(mock2), 0);
    }
    assert_int_equal(reach(&one, "", "H0000003", &err), DX_DRIVER_E_GONE);
    assert_string_equal(err.text, "no scanner with serial number 'H0000003': usb 1-1 has "
                                  "'H0614967'; usb 1-2 has 'H0000002'");
    assert_int_equal(mock_usb_n_claimed(mock) + mock_usb_n_claimed(mock2), 0);
}

/* Without a serial it is the first that is free; and what another stream has is known. */
static void takes_one_that_is_free(void **state)
{
    struct dx_device *one = start("", ""), *two, *three;
    struct dx_err err = {""};

    (void)state;
    assert_int_equal(reach(&two, "", "H0614967", &err), -EBUSY); /* it may be asked only */
    assert_non_null(strstr(err.text, "another program has interface"));
    expect_place(one, "H0614967", "usb 1-1");
    assert_int_equal(reach(&two, "", "", &err), -EBUSY);
    assert_non_null(strstr(err.text, "another program has interface"));
    assert_int_equal(reach(&two, "", "H0000002", &err), DX_DRIVER_E_GONE);
    assert_string_equal(err.text,
                        "no scanner with serial number 'H0000002': usb 1-1 has 'H0614967'");
    plug_second("H0000002", NULL);
    two = start("", "");
    expect_place(two, "H0000002", "usb 1-2");
    assert_int_equal(reach(&three, "", "", &err), -EBUSY);
    stop(one);
    stop(two);
}

/* What USB tells is enough: a scanner that says nothing need not. */
static void goes_by_the_serial_of_usb(void **state)
{
    struct dx_device *dev = NULL;
    struct dx_err err = {""};

    (void)state;
    plug_second(NULL, "U2");
    mock_usb_lock(mock);
    sim.faults.mute = true;
    mock_usb_unlock(mock);
    dev = start("", "U2");
    expect_place(dev, "", "usb 1-2");
    stop(dev);
    assert_int_equal(reach(&dev, "", "U3", &err), -ETIMEDOUT); /* it may be the mute one */
    assert_string_equal(err.text, "no scanner with serial number 'U3': usb 1-1 does not say who it "
                                  "is; usb 1-2 tells none");
}

/* Whoever stops the stream does not wait until all have been asked. */
static void asking_can_be_woken(void **state)
{
    const struct dx_hokuyo_config c = {.serial = (char *)(uintptr_t) "H1",
                                       .first_step = -1,
                                       .last_step = -1,
                                       .cluster = 1,
                                       .stage = {.angle = {.rpm = 10}}};
    struct dx_device *dev;
    struct dx_err err = {""};

    (void)state;
    set_faults((struct scip_faults){.mute = true});
    assert_int_equal(dx_hokuyo_driver.open(&dev, &c, &err), 0);
    for (int k = 0; k < 100; k++) { /* not woken each would take 100 ms; it has three seconds */
        dx_hokuyo_driver.wake(dev);
        assert_int_equal(dx_hokuyo_driver.connect(dev, &err), DX_DRIVER_E_AGAIN);
    }
    stop(dev);
    assert_int_equal(mock_usb_n_claimed(mock), 0);
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
    stop(dev);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(streams, setup, teardown),
        cmocka_unit_test_setup_teardown(tells_of_empty_columns, setup, teardown),
        cmocka_unit_test_setup_teardown(obeys_the_interlock, setup, teardown),
        cmocka_unit_test_setup_teardown(refuses_another_serial, setup, teardown),
        cmocka_unit_test_setup_teardown(finds_each_its_own, setup, teardown),
        cmocka_unit_test_setup_teardown(takes_one_that_is_free, setup, teardown),
        cmocka_unit_test_setup_teardown(goes_by_the_serial_of_usb, setup, teardown),
        cmocka_unit_test_setup_teardown(asking_can_be_woken, setup, teardown),
        cmocka_unit_test_setup_teardown(is_unplugged, setup, teardown),
    };

    (void)argc;
    mock_usb_wrap(argv);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
