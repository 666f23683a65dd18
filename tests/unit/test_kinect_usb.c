/*
 * The Kinect driver whole, and isochronous streams of drivers/usb, over a fake of libusb of our own
 * (fake_libusb.h): a simulated camera answers. No bus and no kernel is in it.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "drivers/kinect/kinect_decode.h"
#include "drivers/monotonic.h"
#include "tests/unit/fake_libusb.h"
#include "tools/alloc_count.h"

#include <errno.h>
#include <libusb-1.0/libusb.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char none[] = "";
static struct dx_kinect_config config;
static uint16_t depths[DX_KINECT_PIXELS];
static uint8_t packed[DX_KINECT_PIXELS / 8 * 11]; /* the same, as the camera sends them */
static const struct dx_driver *const driver = &dx_kinect_driver;

/* Depths that codes have, and some of no return. */
static int make_depths(void **state)
{
    (void)state;
    fake_libusb_reset();
    dx_kinect_lut_fill(depths, &fake_libusb.sim.constants, 11, 10000);
    for (uint32_t k = DX_KINECT_PIXELS; k-- > 0;)
        depths[k] = k % 97 ? depths[500 + k * 7 % 480] : 0;
    kinect_sim_depths(&fake_libusb.sim, depths);
    memcpy(packed, fake_libusb.sim.packed, sizeof(packed));
    return 0;
}

static int setup(void **state)
{
    (void)state;
    fake_libusb_reset();
    config = (struct dx_kinect_config){
        .serial = none, .port = none, .bits = 11, .max_m = 10, .cx = -1, .cy = -1};
    return 0;
}

static int all_is_given_back(void **state)
{
    const struct fake_libusb *f = &fake_libusb;

    (void)state;
    return f->n_contexts || f->n_handles || f->n_transfers || f->n_flying || f->n_claimed ||
           f->n_configs || f->n_lists;
}

/* Opens it, and asks it for its constants. */
static int reach(struct dx_device **dev, struct dx_err *err)
{
    int r = driver->open(dev, &config, err);

    if (r)
        return r;
    r = driver->connect(*dev, err);
    if (r)
        driver->close(*dev);
    return r;
}

static struct dx_device *open_it(void)
{
    struct dx_device *dev = NULL;
    struct dx_err err;
    int r = reach(&dev, &err);

    if (r)
        print_message("%s\n", err.text);
    assert_int_equal(r, 0);
    return dev;
}

static struct dx_device *start_it(void)
{
    struct dx_device *dev = open_it();
    struct dx_err err;

    memcpy(fake_libusb.sim.packed, packed, sizeof(packed));
    assert_int_equal(driver->start(dev, &err), 0);
    return dev;
}

static void end_it(struct dx_device *dev)
{
    driver->stop(dev);
    driver->close(dev);
}

static int read_block(struct dx_device *dev, struct dx_block *block)
{
    struct dx_err err;
    int r;

    do
        r = driver->read(dev, block, &err);
    while (r == DX_DRIVER_E_AGAIN);
    return r;
}

/* ---- a sink of one frame
 * ------------------------------------------------------------------------- */

struct sink {
    struct dx_plane plane;
    unsigned n_frames;
};

static int sink_geometry(void *ctx, struct dx_geometry *g, uint8_t attr_bytes)
{
    return dx_plane_init_for(&((struct sink *)ctx)->plane, g, attr_bytes);
}

static struct dx_plane *sink_plane(void *ctx, uint64_t number)
{
    (void)number;
    return &((struct sink *)ctx)->plane;
}

static void sink_deliver(void *ctx, const struct dx_frame_part *part)
{
    struct sink *s = ctx;

    assert_int_equal(part->frame, s->n_frames);
    s->n_frames++;
}

/* Each pixel is what the camera saw; or, with holes, none. */
static void expect_depths(struct dx_device *dev, const struct dx_block *block, struct sink *s,
                          bool holes)
{
    const struct dx_frame_sink sink = {s, sink_geometry, sink_plane, sink_deliver};
    struct dx_err err;

    assert_int_equal(driver->decode(dev, block, &sink, &err), 0);
    if (!holes)
        assert_memory_equal(s->plane.range, depths, sizeof(depths));
    for (size_t k = 0; k < DX_KINECT_PIXELS; k++) {
        uint32_t mm = dx_plane_range(&s->plane, k);

        if (mm && mm != depths[k])
            assert_int_equal(mm, depths[k]);
    }
}

/* ---- tests
 * --------------------------------------------------------------------------------------- */

static void frames_come_from_the_camera(void **state)
{
    struct sink s = {.n_frames = 0};
    struct dx_device *decoder = NULL, *dev = start_it();
    struct dx_device_health health;
    struct dx_block block;
    uint64_t before = 0, allocated = 0;

    (void)state;
    assert_int_equal(fake_libusb.flying_at_start, 16 + 1); /* and the register's own */
    driver->open_decoder(&decoder, &config, NULL);
    for (unsigned n = 0; n < 20; n++) {
        if (n == 2)
            allocated = dx_alloc_count();
        assert_int_equal(read_block(dev, &block), 0);
        assert_int_equal(block.number, n);
        assert_int_equal(block.first, n == 0);
        assert_int_equal(block.stamp.clock_id, DX_CLOCK_DEVICE);
        assert_true(n == 0 || block.stamp.device_ns > before);
        assert_string_equal(block.source, "usb:3-1.4");
        before = block.stamp.device_ns;
        expect_depths(decoder, &block, &s, false);
    }
    assert_int_equal(dx_alloc_count() - allocated, fake_libusb.n_lists); /* none */
    driver->health(dev, &health);
    assert_string_equal(health.serial, "A00366902968103A");
    assert_string_equal(health.place, "3-1.4");
    assert_string_equal(health.trouble, "");
    assert_int_equal(health.n_lost + health.n_damaged, 0);
    end_it(dev);
    assert_false(kinect_sim_streams(&fake_libusb.sim)); /* the projector is off */
    driver->close(decoder);
    dx_plane_fini(&s.plane);
}

/* More frames come in each round than there is room for: those that are given are whole. */
static void frames_that_nobody_reads_make_way(void **state)
{
    struct dx_device *dev = start_it();
    struct dx_device_health health;
    struct dx_kinect_header h;
    struct dx_block block;
    struct dx_err err;
    uint32_t ticks = 0;

    (void)state;
    fake_libusb.burst = 64;
    for (unsigned n = 0; n < 12; n++) {
        assert_int_equal(read_block(dev, &block), 0);
        assert_int_equal(dx_kinect_header_get(&h, &block, &err), 0);
        assert_true(h.ticks > ticks);
        ticks = h.ticks;
        assert_memory_equal(block.bytes + DX_KINECT_HEADER_LEN, fake_libusb.sim.packed,
                            dx_kinect_frame_len(11));
    }
    driver->health(dev, &health);
    assert_true(h.n_frames_lost > 0 && h.n_frames_lost <= health.n_lost);
    end_it(dev);
}

static void losses_are_told_and_never_seen(void **state)
{
    struct sink s = {.n_frames = 0};
    struct dx_device *dev = start_it();
    struct dx_device_health health;
    struct dx_block block;

    (void)state;
    fake_libusb.sim.faults.lose_ppm = 50000;
    fake_libusb.packet_status = LIBUSB_TRANSFER_ERROR; /* a tenth besides */
    fake_libusb.sim.faults.idle_every = 7;
    for (unsigned n = 0; n < 30; n++) {
        assert_int_equal(read_block(dev, &block), 0);
        expect_depths(dev, &block, &s, true);
    }
    driver->health(dev, &health);
    assert_non_null(strstr(health.trouble, "% of the USB packets are lost"));
    /* It is over; and then too many are lost in a row for any frame. */
    fake_libusb.packet_status = 0;
    fake_libusb.sim.faults = (struct kinect_sim_faults){.lose_ppm = 0};
    while (health.trouble[0]) {
        assert_int_equal(read_block(dev, &block), 0);
        driver->health(dev, &health);
    }
    fake_libusb.sim.faults = (struct kinect_sim_faults){.lose_at = 100, .lose_n = 7};
    while (!health.trouble[0]) {
        driver->read(dev, &block, NULL);
        driver->health(dev, &health);
    }
    assert_true(health.n_lost > 0);
    end_it(dev);
    dx_plane_fini(&s.plane);
}

static void an_unplug_is_gone(void **state)
{
    struct dx_device *dev = start_it();
    struct dx_block block;
    struct dx_err err;

    (void)state;
    fake_libusb.unplug_after = 100;
    while (read_block(dev, &block) == 0)
        ;
    assert_false(fake_libusb.plugged);
    assert_int_equal(driver->read(dev, &block, &err), DX_DRIVER_E_GONE);
    assert_non_null(strstr(err.text, "port 3-1.4"));
    end_it(dev);
    assert_int_equal(driver->open(&dev, &config, &err), DX_DRIVER_E_GONE);
    assert_non_null(strstr(err.text, "12 V"));
    fake_libusb.plugged = true; /* again */
    fake_libusb.unplug_after = 0;
    dev = start_it();
    assert_int_equal(read_block(dev, &block), 0);
    assert_true(block.first && block.number == 0);
    end_it(dev);
}

static void what_keeps_it_from_opening_is_told(void **state)
{
    struct dx_device *dev;
    struct dx_err err;

    (void)state;
    fake_libusb.open_error = LIBUSB_ERROR_ACCESS;
    assert_int_equal(driver->open(&dev, &config, &err), -EACCES);
    assert_non_null(strstr(err.text, "/dev/bus/usb/003/007"));
    fake_libusb.open_error = 0;
    fake_libusb.claim_error = LIBUSB_ERROR_BUSY;
    assert_int_equal(driver->open(&dev, &config, &err), -EBUSY);
    assert_non_null(strstr(err.text, "another program"));
    fake_libusb.claim_error = 0;
    fake_libusb.sim.constants.pixel_mm = 0;
    assert_int_equal(reach(&dev, &err), -EPROTO);
    fake_libusb.sim.constants.pixel_mm = 0.1042f;
    config.near = true;
    assert_int_equal(driver->open(&dev, &config, &err), -ENOTSUP);
    config.near = false;
    dev = open_it();
    fake_libusb.sim.faults.refuse = true;
    assert_int_equal(driver->start(dev, &err), -EPROTO);
    assert_non_null(strstr(err.text, "register 0x105"));
    driver->close(dev);
}

static void the_windows_model_has_its_own_setting(void **state)
{
    struct dx_device *dev;
    struct dx_block block;

    (void)state;
    fake_libusb.sim.windows = true;
    config.near = true;
    dev = start_it();
    assert_int_equal(fake_libusb.alt, 1);
    assert_int_equal(fake_libusb.sim.registers[0x15], 7);
    assert_int_equal(read_block(dev, &block), 0);
    driver->stop(dev);
    assert_int_equal(fake_libusb.sim.registers[0x15], 30);
    assert_int_equal(fake_libusb.sim.registers[0x2ef], 400);
    driver->close(dev);
}

/* Replies that take their time, and those to a program that was there before. */
static void replies_are_waited_for(void **state)
{
    struct dx_device *dev;
    struct dx_err err;

    (void)state;
    fake_libusb.sim.faults.n_silent = 3;
    fake_libusb.sim.faults.n_stale = 2;
    dev = start_it();
    end_it(dev);
    fake_libusb.sim.faults.n_stale = 1000000;
    assert_int_equal(reach(&dev, &err), -EPROTO);
    assert_non_null(strstr(err.text, "found the reply to command 0x04"));
}

/* One that answers nothing is asked for a second: whoever stops the stream does not wait for that.
 */
static void asking_can_be_woken(void **state)
{
    struct dx_device *dev;
    struct dx_err err;

    (void)state;
    fake_libusb.sim.faults.n_silent = 1000000;
    assert_int_equal(driver->open(&dev, &config, &err), 0);
    for (int k = 0; k < 3; k++) {
        driver->wake(dev);
        assert_int_equal(driver->connect(dev, &err), DX_DRIVER_E_AGAIN);
    }
    assert_true(driver->connect(dev, &err) < 0);
    fake_libusb.sim.faults.n_silent = 0;
    driver->wake(dev);
    while (driver->connect(dev, &err) == DX_DRIVER_E_AGAIN)
        ; /* asked anew, it answers */
    assert_int_equal(driver->start(dev, &err), 0);
    end_it(dev);
}

static void *wake(void *ctx)
{
    driver->wake(ctx);
    return NULL;
}

static void a_silent_camera_keeps_nobody(void **state)
{
    struct dx_device *dev = start_it();
    struct dx_block block;
    struct dx_err err;
    pthread_t thread;

    (void)state;
    fake_libusb.sim.registers[0x06] = 0;
    while (driver->read(dev, &block, &err) == 0)
        ;
    assert_int_equal(driver->read(dev, &block, &err), DX_DRIVER_E_AGAIN);
    assert_int_equal(pthread_create(&thread, NULL, wake, dev), 0);
    assert_int_equal(driver->read(dev, &block, &err), DX_DRIVER_E_AGAIN);
    pthread_join(thread, NULL);
    end_it(dev);
}

static void a_stream_that_only_fails_ends(void **state)
{
    struct dx_device *dev = start_it();
    struct dx_block block;
    struct dx_err err;

    (void)state;
    assert_int_equal(read_block(dev, &block), 0);
    fake_libusb.transfer_status = LIBUSB_TRANSFER_ERROR;
    fake_libusb.n_isochronous = 0;
    while (driver->read(dev, &block, &err) == 0)
        ;
    assert_int_equal(driver->read(dev, &block, &err), -EIO);
    assert_non_null(strstr(err.text, "endpoint 0x82"));
    assert_true(fake_libusb.n_isochronous <= 4 * 16);
    end_it(dev);
}

/* Nor when the camera says no word more: a stop is no longer than 0.3 s, of near mode as well. (Of
 * the clock; fast_waits.c.) */
static void a_stop_waits_for_no_answer(void **state)
{
    struct dx_device *dev;
    struct dx_block block;
    uint64_t start_ns;

    (void)state;
    fake_libusb.sim.windows = true;
    config.near = true;
    dev = start_it();
    assert_int_equal(read_block(dev, &block), 0);
    fake_libusb.sim.faults.n_silent = 1000000;
    start_ns = dx_clock_ns();
    end_it(dev);
    assert_true(dx_clock_ns() - start_ns < UINT64_C(1000000000)); /* each answer had a second */
}

/* The kernel keeps the transfers: all else is given back, and close ends. */
static void a_close_ends_whatever_is_stuck(void **state)
{
    struct dx_device *dev = start_it();
    struct dx_block block;

    (void)state;
    assert_int_equal(read_block(dev, &block), 0);
    fake_libusb.never_return = true;
    end_it(dev);
    assert_int_equal(fake_libusb.n_transfers, 16);
    assert_int_equal(fake_libusb.n_flying, 16);
    assert_int_equal(fake_libusb.n_handles, 0);
    assert_int_equal(fake_libusb.n_contexts, 0);
    fake_libusb.n_transfers = fake_libusb.n_flying = 0; /* left behind on purpose */
}

static void keep(void *ctx, const struct dx_device_found *found)
{
    snprintf(ctx, 300, "%s|%s|%s|%s|%s|%d", found->name, found->node, found->serial, found->place,
             found->yaml, found->access);
}

static void it_is_found(void **state)
{
    char text[300] = "";
    struct dx_err err;

    (void)state;
    assert_int_equal(driver->probe(keep, text, &err), 0);
    assert_string_equal(text, "Kinect for Xbox 360, depth|/dev/bus/usb/003/007|A00366902968103A|"
                              "3-1.4|serial: \"A00366902968103A\"\n|0");
    fake_libusb.serial = "A\"0\\n\\";
    assert_int_equal(driver->probe(keep, text, &err), 0);
    assert_string_equal(text, "Kinect for Xbox 360, depth|/dev/bus/usb/003/007|A\"0\\n\\|"
                              "3-1.4|serial: \"A\\\"0\\\\n\\\\\"\n|0");
    fake_libusb.open_error = LIBUSB_ERROR_ACCESS;
    assert_int_equal(driver->probe(keep, text, &err), 0);
    assert_string_equal(text, "Kinect for Xbox 360, depth|/dev/bus/usb/003/007||3-1.4|"
                              "port: \"3-1.4\"\n|-13");
    fake_libusb.plugged = false;
    text[0] = '\0';
    assert_int_equal(driver->probe(keep, text, &err), 0);
    assert_string_equal(text, "");
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, setup, all_is_given_back)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(frames_come_from_the_camera),
        TEST(frames_that_nobody_reads_make_way),
        TEST(losses_are_told_and_never_seen),
        TEST(an_unplug_is_gone),
        TEST(what_keeps_it_from_opening_is_told),
        TEST(the_windows_model_has_its_own_setting),
        TEST(replies_are_waited_for),
        TEST(asking_can_be_woken),
        TEST(a_silent_camera_keeps_nobody),
        TEST(a_stream_that_only_fails_ends),
        TEST(a_stop_waits_for_no_answer),
        TEST(a_close_ends_whatever_is_stuck),
        TEST(it_is_found),
    };

    return cmocka_run_group_tests(tests, make_depths, NULL);
}
