/* What may come of a wait for a camera's frame, row by row (docs/drivers/v4l2.md), on a scripted
 * kernel; and waking. */
#include "tests/unit/v4l2_bed.h"
#include "tests/unit/v4l2_fixture.h"

static struct dx_device *dev;
static struct dx_err err;

static int set_up(void **state)
{
    struct dx_v4l2_config c = v4l2_config();

    if (kernel_set_up(state))
        return -1;
    kernel_plug("video0", 2, "1", KERNEL_CAPTURE, V4L2_PIX_FMT_Z16, 0);
    dev = NULL;
    if (dx_v4l2_driver.open(&dev, &c, &err) || dx_v4l2_driver.start(dev, &err))
        fail_msg("%s", err.text);
    return 0;
}

static int tear_down(void **state)
{
    dx_v4l2_driver.close(dev);
    return kernel_tear_down(state);
}

static int read_one(void)
{
    struct dx_block block;

    return dx_v4l2_driver.read(dev, &block, &err);
}

/* The next frame comes, and is the camera's frame `sequence`. */
static void expect_frame(uint32_t sequence)
{
    struct dx_v4l2_layout layout;
    struct dx_v4l2_header h;
    struct dx_block block;
    int r = dx_v4l2_driver.read(dev, &block, &err);

    if (r)
        fail_msg("read: %d %s", r, err.text);
    assert_int_equal(dx_v4l2_header_get(&h, &layout, &block, &err), 0);
    assert_int_equal(h.sequence, sequence);
}

static void expect_again(void)
{
    int r = read_one();

    if (r != DX_DRIVER_E_AGAIN)
        fail_msg("read: %d %s", r, err.text);
}

static void expect_end(int code, const char *text)
{
    int r = read_one();

    if (r != code || !strstr(err.text, text))
        fail_msg("read: %d '%s', expected %d '%s'", r, err.text, code, text);
}

static struct dx_device_health health(void)
{
    struct dx_device_health h;

    dx_v4l2_driver.health(dev, &h);
    return h;
}

static void test_not_ready(void **state)
{
    (void)state;
    KERNEL_SCRIPT(STEP_FRAME, STEP_EAGAIN, STEP_FRAME);
    expect_frame(0);
    expect_again();
    expect_frame(1);
    assert_int_equal(kernel.n_on, 1);
}

/* Frames that came damaged or short are left out and counted, and their buffers go back. */
static void test_damaged(void **state)
{
    (void)state;
    KERNEL_SCRIPT(STEP_FRAME, STEP_DAMAGED, STEP_SHORT, STEP_FRAME);
    expect_frame(0);
    expect_again();
    assert_int_equal(kernel.n_queued, KERNEL_BUFFERS);
    expect_again();
    assert_int_equal(kernel.n_queued, KERNEL_BUFFERS);
    expect_frame(3);
    assert_int_equal(health().n_damaged, 2);
    assert_int_equal(health().n_lost, 0);
}

static void test_lost(void **state)
{
    (void)state;
    KERNEL_SCRIPT(STEP_FRAME, STEP_LOST, STEP_FRAME, STEP_FRAME, STEP_LOST, STEP_DAMAGED,
                  STEP_FRAME);
    expect_frame(0);
    expect_again(); /* it is waited for */
    expect_frame(4);
    assert_int_equal(health().n_lost, 3);
    expect_frame(5);
    expect_again();
    expect_again();
    expect_frame(10);
    assert_int_equal(health().n_lost, 6);
    assert_int_equal(health().n_damaged, 1);
}

/* As uvcvideo gives them on a busy machine: the second before the first; then so late that it is
 * given up. */
static void test_out_of_order(void **state)
{
    (void)state;
    KERNEL_SCRIPT(STEP_FRAME, STEP_AHEAD, STEP_FRAME, STEP_BACK, STEP_FRAME, STEP_AHEAD, STEP_FRAME,
                  STEP_AHEAD, STEP_FRAME, STEP_FRAME, STEP_BACK, STEP_BACK, STEP_AHEAD, STEP_FRAME,
                  STEP_AHEAD, STEP_AHEAD, STEP_FRAME);
    expect_frame(0);
    expect_again();
    expect_frame(1);
    expect_frame(2);
    expect_frame(3);
    assert_int_equal(health().n_lost, 0);
    expect_again();
    expect_frame(5);
    assert_int_equal(health().n_lost, 1);
    expect_frame(6);
    expect_again(); /* 4 */
    expect_frame(7);
    assert_int_equal(health().n_lost, 1);
    assert_int_equal(health().n_damaged, 0);
}

/* An I/O error: all buffers taken back, all queued again; the new sequence is no loss. */
static void test_io_error(void **state)
{
    (void)state;
    KERNEL_SCRIPT(STEP_FRAME, STEP_FRAME, STEP_EIO, STEP_FRAME, STEP_FRAME);
    expect_frame(0);
    expect_frame(1);
    assert_false(*health().trouble);
    expect_again();
    assert_int_equal(kernel.n_off, 1);
    assert_int_equal(kernel.n_on, 2);
    assert_int_equal(kernel.n_queued, KERNEL_BUFFERS);
    assert_non_null(strstr(health().trouble, "started anew, 1 in all"));
    expect_frame(0);
    expect_frame(1);
    assert_int_equal(health().n_lost, 0);
}

/* Three in ten seconds: it is to be opened anew. */
static void test_io_errors(void **state)
{
    (void)state;
    KERNEL_SCRIPT(STEP_EIO, STEP_FRAME, STEP_EIO, STEP_EIO);
    expect_again();
    expect_frame(0);
    kernel.ahead_ns += 9000000000;
    expect_again();
    expect_end(-EIO, "/dev/video0: input/output error, 3 times in 10 s");
    assert_int_equal(kernel.n_on, 3);
}

/* Any number of them when they are rarer than that. */
static void test_rare_io_errors(void **state)
{
    (void)state;
    KERNEL_SCRIPT(STEP_EIO, STEP_EIO, STEP_EIO, STEP_EIO, STEP_EIO, STEP_EIO, STEP_FRAME);
    for (int k = 0; k < 6; k++) {
        kernel.ahead_ns += 6000000000;
        expect_again();
    }
    expect_frame(0);
    assert_int_equal(kernel.n_on, 7);
    kernel.ahead_ns += 60000000000;
    assert_false(*health().trouble);
}

static void test_restart_fails(void **state)
{
    (void)state;
    KERNEL_SCRIPT(STEP_EIO);
    kernel.n_ioctls = 0;
    kernel.fail_at = 2; /* DQBUF, then STREAMOFF */
    kernel.fail_code = ENODEV;
    expect_end(DX_DRIVER_E_GONE, "/dev/video0: unplugged");
}

/* A start that fails half way can be tried again. */
static void test_start_fails(void **state)
{
    (void)state;
    dx_v4l2_driver.stop(dev);
    kernel.n_ioctls = 0;
    kernel.fail_at = KERNEL_BUFFERS + 1; /* STREAMON */
    kernel.fail_code = EBUSY;
    assert_int_equal(dx_v4l2_driver.start(dev, &err), -EBUSY);
    assert_non_null(strstr(err.text, "/dev/video0: VIDIOC_STREAMON: Device or resource busy"));
    assert_int_equal(kernel.n_queued, 0);
    KERNEL_SCRIPT(STEP_FRAME);
    assert_int_equal(dx_v4l2_driver.start(dev, &err), 0);
    expect_frame(0);
}

static void test_ended(void **state)
{
    (void)state;
    KERNEL_SCRIPT(STEP_FRAME, STEP_EPIPE);
    expect_frame(0);
    expect_end(-EPIPE, "/dev/video0: has ended its stream");
}

static void test_end_event(void **state)
{
    (void)state;
    KERNEL_SCRIPT(STEP_FRAME, STEP_END);
    expect_frame(0);
    expect_end(-EPIPE, "/dev/video0: has ended its stream");
}

static void test_lost_state(void **state)
{
    (void)state;
    KERNEL_SCRIPT(STEP_FRAME, STEP_EINVAL);
    expect_frame(0);
    expect_end(-EINVAL, "/dev/video0: VIDIOC_DQBUF: Invalid argument");
}

static void test_unplugged_ioctl(void **state)
{
    (void)state;
    KERNEL_SCRIPT(STEP_FRAME, STEP_ENODEV);
    expect_frame(0);
    expect_end(DX_DRIVER_E_GONE, "/dev/video0: unplugged");
}

static void test_unplugged_poll(void **state)
{
    (void)state;
    KERNEL_SCRIPT(STEP_FRAME, STEP_EAGAIN, STEP_UNPLUG);
    expect_frame(0);
    expect_again();
    expect_end(DX_DRIVER_E_GONE, "/dev/video0: unplugged");
}

/* While the reader has a frame: giving it back tells. The frame's memory holds until then. */
static void test_unplugged_held(void **state)
{
    struct dx_block block;

    (void)state;
    KERNEL_SCRIPT(STEP_FRAME);
    assert_int_equal(dx_v4l2_driver.read(dev, &block, &err), 0);
    kernel.gone = true;
    assert_int_equal(block.bytes[block.len - 1], 1000 >> 8);
    expect_end(DX_DRIVER_E_GONE, "/dev/video0: unplugged");
}

static void close_it(void)
{
    dx_v4l2_driver.close(dev);
    dev = NULL;
}

/* An unplugged camera is closed when the kernel has taken it down, or never does; others at once.
 */
static void test_closed_when_down(void **state)
{
    (void)state;
    KERNEL_SCRIPT(STEP_FRAME, STEP_UNPLUG);
    expect_frame(0);
    expect_end(DX_DRIVER_E_GONE, "/dev/video0: unplugged");
    kernel.removed = "/sys" KERNEL_USB "2/1-2:1.0";
    kernel.pauses_to_removal = 3;
    close_it();
    assert_int_equal(kernel.n_pauses, 3);
}

static void test_closed_all_the_same(void **state)
{
    (void)state;
    KERNEL_SCRIPT(STEP_UNPLUG);
    expect_end(DX_DRIVER_E_GONE, "/dev/video0: unplugged");
    close_it();
    assert_int_equal(kernel.n_pauses, 50);
}

static void test_closed_at_once(void **state)
{
    (void)state;
    KERNEL_SCRIPT(STEP_FRAME, STEP_EINVAL);
    expect_frame(0);
    expect_end(-EINVAL, "VIDIOC_DQBUF");
    close_it();
    assert_int_equal(kernel.n_pauses, 0);
}

/* One error of poll alone is waited out; two in a row start the stream anew; more, the camera. */
static void test_poll_error(void **state)
{
    (void)state;
    KERNEL_SCRIPT(STEP_POLL_ERROR, STEP_FRAME, STEP_POLL_ERROR, STEP_POLL_ERROR, STEP_FRAME);
    expect_again();
    expect_frame(0);
    expect_again();
    assert_int_equal(kernel.n_on, 1);
    expect_again();
    assert_int_equal(kernel.n_on, 2);
    expect_frame(0);
    KERNEL_SCRIPT(STEP_POLL_ERROR, STEP_POLL_ERROR, STEP_POLL_ERROR, STEP_POLL_ERROR);
    expect_again();
    expect_again();
    assert_int_equal(kernel.n_on, 3);
    expect_again();
    expect_end(-EIO, "/dev/video0: poll tells of an error, 3 times in 10 s");
}

/* ---- the source changes -------------------------------------------------------------------------
 */

static void decode_next(struct v4l2_sink *s)
{
    const struct dx_frame_sink sink = v4l2_sink_of(s);
    struct dx_block block;

    assert_int_equal(dx_v4l2_driver.read(dev, &block, &err), 0);
    if (dx_v4l2_driver.decode(dev, &block, &sink, &err))
        fail_msg("%s", err.text);
}

static void test_source_change(void **state)
{
    struct v4l2_sink s = {0};

    (void)state;
    kernel.next_width = 24;
    KERNEL_SCRIPT(STEP_FRAME, STEP_CHANGE, STEP_FRAME);
    decode_next(&s);
    assert_int_equal(s.g->width, 16);
    expect_again();
    assert_int_equal(kernel.n_released, 1); /* the old buffers */
    assert_int_equal(kernel_n_mappings(), 1 + KERNEL_BUFFERS);
    assert_int_equal(kernel.n_off, 1);
    decode_next(&s);
    assert_int_equal(s.g->width, 24);
    assert_int_equal(s.n_geometries, 2);
    assert_int_equal(dx_plane_range(&s.plane, 23), 1023);
    /* the same size: all is set up again, and the geometry stays */
    KERNEL_SCRIPT(STEP_CHANGE, STEP_FRAME);
    expect_again();
    assert_int_equal(kernel.n_released, 2);
    decode_next(&s);
    assert_int_equal(s.n_geometries, 2);
    assert_int_equal(s.n_frames, 3);
    v4l2_sink_fini(&s);
}

/* An event of another kind does not keep the frame that came with it. */
static void test_other_event(void **state)
{
    (void)state;
    KERNEL_SCRIPT(STEP_FRAME, STEP_OTHER, STEP_FRAME);
    expect_frame(0);
    expect_frame(1);
    expect_frame(2);
    assert_int_equal(kernel.n_on, 1);
}

static void test_source_change_fails(void **state)
{
    (void)state;
    kernel.next_width = 24;
    kernel.n_given = 1;
    KERNEL_SCRIPT(STEP_CHANGE);
    expect_end(-ENOMEM, "/dev/video0: gives 1 buffers");
    assert_int_equal(kernel_n_mappings(), 1);
}

/* ---- waiting ------------------------------------------------------------------------------------
 */

static void test_silence(void **state)
{
    (void)state;
    KERNEL_SCRIPT(STEP_NONE);
    expect_again();
    assert_int_equal(kernel.n_polls, 1);
    assert_int_equal(kernel.timeout_ms, 100);
}

static void *wake(void *unused)
{
    dx_v4l2_driver.wake(dev);
    return unused;
}

/* Before the read or while it waits; once, and then frames come as before. */
static void test_wake(void **state)
{
    pthread_t thread;

    (void)state;
    KERNEL_SCRIPT(STEP_FRAME);
    dx_v4l2_driver.wake(dev);
    expect_again();
    assert_int_equal(kernel.at, 0);
    expect_frame(0);
    assert_int_equal(pthread_create(&thread, NULL, wake, NULL), 0);
    expect_again();
    pthread_join(thread, NULL);
}

#define TEST(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(test_not_ready),
        TEST(test_damaged),
        TEST(test_lost),
        TEST(test_out_of_order),
        TEST(test_io_error),
        TEST(test_io_errors),
        TEST(test_rare_io_errors),
        TEST(test_restart_fails),
        TEST(test_start_fails),
        TEST(test_ended),
        TEST(test_end_event),
        TEST(test_lost_state),
        TEST(test_unplugged_ioctl),
        TEST(test_unplugged_poll),
        TEST(test_unplugged_held),
        TEST(test_closed_when_down),
        TEST(test_closed_all_the_same),
        TEST(test_closed_at_once),
        TEST(test_poll_error),
        TEST(test_source_change),
        TEST(test_other_event),
        TEST(test_source_change_fails),
        TEST(test_silence),
        TEST(test_wake),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
