/* The V4L2 driver on a scripted kernel: choosing a camera, bring-up, streaming, teardown, another
 * node of the same camera. */
#include "tests/unit/v4l2_bed.h"
#include "tests/unit/v4l2_fixture.h"

static struct dx_device *open_good(const struct dx_v4l2_config *c)
{
    struct dx_device *dev = NULL;
    struct dx_err err = {""};

    if (dx_v4l2_driver.open(&dev, c, &err))
        fail_msg("%s", err.text);
    return dev;
}

static void refuse(const struct dx_v4l2_config *c, int code, const char *text)
{
    struct dx_device *dev = NULL;
    struct dx_err err = {""};
    int r = dx_v4l2_driver.open(&dev, c, &err);

    if (r != code || !strstr(err.text, text))
        fail_msg("%d '%s', expected %d '%s'", r, err.text, code, text);
    assert_null(dev);
}

/* Where the camera is: a node of the open device. */
static void expect_node(struct dx_device *dev, const char *node)
{
    char text[200];

    dx_v4l2_driver.describe(dev, text, sizeof(text));
    if (strncmp(text, node, strlen(node)) || text[strlen(node)] != ':')
        fail_msg("'%s' is not %s", text, node);
}

static void plug_d4xx(void)
{
    kernel_plug("video0", 2, "845112", V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING,
                V4L2_META_FMT_UVC, 0);
    kernel_plug("video1", 2, "845112", KERNEL_CAPTURE, V4L2_PIX_FMT_GREY, V4L2_PIX_FMT_UYVY);
    kernel_plug("video2", 2, "845112", KERNEL_CAPTURE, V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_Z16);
}

static void test_bring_up(void **state)
{
    char serial[] = "845112", text[200];
    struct dx_v4l2_config c = v4l2_config();
    struct dx_device_health health;
    struct dx_device *dev;

    (void)state;
    plug_d4xx();
    c.serial = serial;
    c.width = 16;
    c.height = 6;
    c.fps = 90;
    dev = open_good(&c);
    expect_node(dev, "/dev/video2"); /* the one with depths */
    assert_int_equal(kernel.asked.type, V4L2_BUF_TYPE_VIDEO_CAPTURE);
    assert_int_equal(kernel.asked.fmt.pix.pixelformat, V4L2_PIX_FMT_Z16);
    assert_int_equal(kernel.asked.fmt.pix.width, 16);
    assert_int_equal(kernel.asked.fmt.pix.height, 6);
    assert_int_equal(kernel.asked.fmt.pix.field, V4L2_FIELD_NONE);
    assert_true(kernel.rate.numerator == 1000 && kernel.rate.denominator == 90000);
    assert_int_equal(kernel.n_buffers, KERNEL_BUFFERS);
    assert_int_equal(kernel_n_mappings(), 1 + KERNEL_BUFFERS); /* the test's own, too */
    assert_int_equal(kernel.n_on, 0);
    dx_v4l2_driver.health(dev, &health);
    assert_string_equal(health.serial, "845112");
    assert_string_equal(health.place, "pci-0000:00:14.0-usb-0:2:1.0");
    assert_true(health.n_lost == 0 && health.n_damaged == 0 && !*health.trouble);
    dx_v4l2_driver.describe(dev, text, sizeof(text));
    assert_string_equal(text, "/dev/video2: Depth One, Z16 16x6, unit 0.001 m, pinhole, 90 frames "
                              "a second");
    assert_true(dx_v4l2_driver.silence_ns(dev) >= 500000000u);
    dx_v4l2_driver.close(dev);
    assert_int_equal(kernel.n_released, 1);
}

static void read_frame(struct dx_device *dev, struct dx_block *block)
{
    struct dx_err err = {""};
    int r = dx_v4l2_driver.read(dev, block, &err);

    if (r)
        fail_msg("read: %d %s", r, err.text);
}

/* Reads a frame and decodes it; its pixels are those of frame `sequence` of the camera. */
static void expect_frame(struct dx_device *dev, struct v4l2_sink *s, uint32_t sequence)
{
    const struct dx_frame_sink sink = v4l2_sink_of(s);
    struct dx_block block;
    struct dx_err err = {""};

    read_frame(dev, &block);
    assert_int_equal(block.stamp.device_ns, 3000000000u + 1000 * (uint64_t)sequence);
    if (dx_v4l2_driver.decode(dev, &block, &sink, &err))
        fail_msg("decode: %s", err.text);
    for (uint32_t k = 0; k < 96; k++)
        assert_int_equal(dx_plane_range(&s->plane, k), 1000 + sequence + (k < 16 ? k : 0));
}

static void stream(struct dx_v4l2_config *c)
{
    struct dx_device *dev = open_good(c);
    struct v4l2_sink s = {0};
    struct dx_err err;
    struct dx_block block;

    KERNEL_SCRIPT(STEP_FRAME, STEP_FRAME, STEP_FRAME, STEP_FRAME, STEP_FRAME, STEP_FRAME,
                  STEP_FRAME, STEP_FRAME, STEP_FRAME, STEP_FRAME);
    assert_int_equal(dx_v4l2_driver.start(dev, &err), 0);
    assert_int_equal(kernel.n_queued, KERNEL_BUFFERS);
    for (uint32_t k = 0; k < 9; k++) {
        expect_frame(dev, &s, k);
        assert_int_equal(kernel.n_queued, KERNEL_BUFFERS - 1); /* the reader has one */
    }
    assert_int_equal(s.n_geometries, 1);
    assert_int_equal(s.part.frame, 8);
    read_frame(dev, &block);
    assert_int_equal(block.number, 9);
    assert_false(block.first);
    assert_int_equal(block.stamp.clock_id, DX_CLOCK_MONOTONIC);
    assert_true(block.stamp.host_ns > 0);
    assert_string_equal(block.source, "/dev/video0");
    dx_v4l2_driver.stop(dev);
    assert_int_equal(kernel.n_off, 1);
    /* and again */
    KERNEL_SCRIPT(STEP_FRAME);
    assert_int_equal(dx_v4l2_driver.start(dev, &err), 0);
    expect_frame(dev, &s, 0);
    dx_v4l2_driver.close(dev); /* stops by itself */
    assert_int_equal(kernel.n_off, 2);
    v4l2_sink_fini(&s);
}

static void test_streaming(void **state)
{
    struct dx_v4l2_config c = v4l2_config();

    (void)state;
    kernel_plug("video0", 2, "1", KERNEL_CAPTURE, V4L2_PIX_FMT_Z16, 0);
    stream(&c);
}

static void test_padded_lines(void **state)
{
    struct dx_v4l2_config c = v4l2_config();

    (void)state;
    kernel.bytesperline = 40;
    kernel_plug("video0", 2, "1", KERNEL_CAPTURE, V4L2_PIX_FMT_Z16, 0);
    stream(&c);
}

static void test_multi_planar(void **state)
{
    struct dx_v4l2_config c = v4l2_config();

    (void)state;
    kernel.planar = true;
    kernel.data_offset = 24;
    kernel_plug("video0", 2, "1", V4L2_CAP_VIDEO_CAPTURE_MPLANE | V4L2_CAP_STREAMING,
                V4L2_PIX_FMT_Z16, 0);
    stream(&c);
    assert_int_equal(kernel.asked.type, V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE);
}

/* A block is a header and the mapped buffer itself: what the camera writes later is in it. */
static void test_no_copy(void **state)
{
    struct dx_v4l2_config c = v4l2_config();
    struct dx_v4l2_layout layout;
    struct dx_v4l2_header h;
    struct dx_device *dev;
    struct dx_block block;
    struct dx_err err;

    (void)state;
    kernel_plug("video0", 2, "1", KERNEL_CAPTURE, V4L2_PIX_FMT_Z16, 0);
    dev = open_good(&c);
    KERNEL_SCRIPT(STEP_FRAME);
    assert_int_equal(dx_v4l2_driver.start(dev, &err), 0);
    read_frame(dev, &block);
    assert_true(block.first);
    assert_int_equal(block.len, DX_V4L2_HEADER_LEN + 6 * 32);
    assert_int_equal(dx_v4l2_header_get(&h, &layout, &block, &err), 0);
    assert_int_equal(h.sequence, 0);
    assert_true(h.flags & V4L2_BUF_FLAG_TSTAMP_SRC_SOE);
    kernel.memory[5] = 0xab;
    assert_int_equal(block.bytes[DX_V4L2_HEADER_LEN + 5], 0xab);
    dx_v4l2_driver.close(dev);
}

/* uvcvideo can be told to stamp by the other clock, and flags it as before. */
static void test_clocks(void **state)
{
    struct dx_v4l2_config c = v4l2_config();
    struct dx_device *dev;
    struct dx_block block;
    struct dx_err err;

    (void)state;
    kernel_plug("video0", 2, "1", KERNEL_CAPTURE, V4L2_PIX_FMT_Z16, 0);
    dev = open_good(&c);
    KERNEL_SCRIPT(STEP_FRAME, STEP_FRAME);
    assert_int_equal(dx_v4l2_driver.start(dev, &err), 0);
    kernel.ahead_ns = -(int64_t)1e18; /* the camera's stamps lie far ahead of the clock */
    read_frame(dev, &block);
    assert_true(block.stamp.host_ns > block.stamp.device_ns + (uint64_t)1e18);
    kernel.ahead_ns = 0;
    kernel.stamp_flags = V4L2_BUF_FLAG_TIMESTAMP_COPY;
    read_frame(dev, &block);
    assert_int_equal(block.stamp.clock_id, DX_CLOCK_DEVICE);
    dx_v4l2_driver.close(dev);
}

static void test_choice(void **state)
{
    char a[] = "845112", b[] = "77", none[] = "78", port[] = "1-3", other_port[] = "1-4";
    char path[] = "/dev/v4l/by-path/port-3-video5", place[] = "pci-0000:00:14.0-usb-0:3:1.0";
    struct dx_v4l2_config c = v4l2_config(), empty = v4l2_config();
    struct dx_device *dev;

    (void)state;
    refuse(&c, DX_DRIVER_E_GONE, "no camera with Z16 or INZI among 0 video nodes");
    plug_d4xx();
    kernel_plug("video5", 3, "77", KERNEL_CAPTURE, V4L2_PIX_FMT_INZI, V4L2_PIX_FMT_Z16);
    refuse(&c, -EINVAL, "more than one depth camera (/dev/video2, /dev/video5): say which");
    c.serial = none;
    refuse(&c, DX_DRIVER_E_GONE, "no camera of serial '78' among 4 video nodes attached");
    c.serial = b;
    c.format = DX_V4L2_Y10B;
    refuse(&c, -EINVAL, "the camera of serial '77' has no format Y10B");
    c.format = DX_V4L2_AUTO;
    dev = open_good(&c);
    expect_node(dev, "/dev/video5");
    dx_v4l2_driver.close(dev);
    c = empty;
    c.port = port;
    dev = open_good(&c);
    expect_node(dev, "/dev/video5");
    dx_v4l2_driver.close(dev);
    c.serial = a; /* of another one than that at the port */
    refuse(&c, DX_DRIVER_E_GONE, "no camera of serial '845112', port '1-3' among 4 video nodes");
    c = empty;
    c.port = other_port;
    refuse(&c, DX_DRIVER_E_GONE, "port '1-4'");
    c = empty;
    c.path = path;
    dev = open_good(&c);
    expect_node(dev, "/dev/video5");
    dx_v4l2_driver.close(dev);
    c.path = place;
    dev = open_good(&c);
    expect_node(dev, "/dev/video5");
    dx_v4l2_driver.close(dev);
    c = empty;
    kernel.refuse_open = true;
    c.serial = b;
    refuse(&c, -EACCES, "/dev/video5: Permission denied; a udev rule grants it: SUBSYSTEM==");
}

/* Unplugged and plugged in elsewhere with other numbers: the serial finds it, nothing is left. */
static void test_another_node(void **state)
{
    char serial[] = "845112";
    struct dx_v4l2_config c = v4l2_config();
    struct v4l2_sink s = {0};
    struct dx_device *dev;
    struct dx_block block;
    struct dx_err err;
    unsigned before;

    (void)state;
    kernel_plug("video0", 2, "845112", KERNEL_CAPTURE, V4L2_PIX_FMT_Z16, 0);
    c.serial = serial;
    dx_v4l2_driver.close(open_good(&c));
    before = kernel_n_descriptors();
    dev = open_good(&c);
    KERNEL_SCRIPT(STEP_FRAME, STEP_UNPLUG);
    assert_int_equal(dx_v4l2_driver.start(dev, &err), 0);
    expect_frame(dev, &s, 0);
    assert_int_equal(dx_v4l2_driver.read(dev, &block, &err), DX_DRIVER_E_GONE);
    dx_v4l2_driver.stop(dev);
    dx_v4l2_driver.close(dev);
    assert_int_equal(kernel_n_descriptors(), before);
    assert_int_equal(kernel_n_mappings(), 1);
    kernel_unplug("video0", 2);
    refuse(&c, DX_DRIVER_E_GONE, "no camera of serial '845112' among 0 video nodes");
    kernel_plug("video4", 5, "845112", KERNEL_CAPTURE, V4L2_PIX_FMT_Z16, 0);
    dev = open_good(&c);
    expect_node(dev, "/dev/video4");
    KERNEL_SCRIPT(STEP_FRAME);
    assert_int_equal(dx_v4l2_driver.start(dev, &err), 0);
    expect_frame(dev, &s, 0);
    dx_v4l2_driver.close(dev);
    v4l2_sink_fini(&s);
}

/* Whichever call of the bring-up fails, nothing is left behind, and an unplugged camera is GONE. */
static void test_bring_up_fails(void **state)
{
    struct dx_v4l2_config c = v4l2_config();
    unsigned before, n, n_failed = 0;

    (void)state;
    kernel_plug("video0", 2, "1", KERNEL_CAPTURE, V4L2_PIX_FMT_Z16, 0);
    dx_v4l2_driver.close(open_good(&c));
    before = kernel_n_descriptors();
    kernel.n_ioctls = 0;
    dx_v4l2_driver.close(open_good(&c));
    n = kernel.n_ioctls;
    assert_true(n > 12);
    for (unsigned at = 1; at <= n; at++)
        for (int k = 0; k < 2; k++) {
            struct dx_device *dev = NULL;
            struct dx_err err = {""};
            int r;

            kernel.n_ioctls = 0;
            kernel.fail_at = at;
            kernel.fail_code = k ? ENODEV : EBUSY;
            r = dx_v4l2_driver.open(&dev, &c, &err);
            n_failed += r != 0;
            if (r && ((k == 1 && r != DX_DRIVER_E_GONE) || !*err.text))
                fail_msg("ioctl %u: %d '%s'", at, r, err.text);
            assert_true((r == 0) == (dev != NULL));
            dx_v4l2_driver.close(dev);
            kernel.fail_at = 0;
            assert_int_equal(kernel_n_descriptors(), before);
            assert_int_equal(kernel_n_mappings(), 1);
        }
    /* QUERYCAP twice, ENUM_FMT twice, S_FMT, REQBUFS, QUERYBUF at the least; events and rates may
     */
    assert_true(n_failed >= 2 * (4 + 2 + KERNEL_BUFFERS));
}

static void test_bad_cameras(void **state)
{
    struct dx_v4l2_config c = v4l2_config(), wide;

    (void)state;
    kernel_plug("video0", 2, "1", KERNEL_CAPTURE, V4L2_PIX_FMT_Z16, 0);
    wide = c;
    wide.width = 17;
    wide.height = 6;
    refuse(&wide, -EINVAL, "/dev/video0: gives Z16 of 16x6, expected 17x6");
    kernel.n_given = 1;
    refuse(&c, -ENOMEM, "/dev/video0: gives 1 buffers, expected 2 or more");
    kernel.n_given = 0;
    kernel.buffer_len = 191;
    refuse(&c, -EINVAL, "/dev/video0: buffer of 191 bytes, expected 192 or more");
    kernel.buffer_len = 0;
    kernel.bytesperline = 31;
    refuse(&c, -EINVAL, "/dev/video0: line of 31 bytes, expected 32 or more");
    kernel.bytesperline = 32;
    kernel.fourcc = V4L2_PIX_FMT_GREY;
    refuse(&c, -EINVAL, "/dev/video0: gives pixel format 59455247, expected Z16");
    kernel.fourcc = V4L2_PIX_FMT_Z16;
    c.lens.k1 = -100;
    refuse(&c, -EINVAL, "the lens folds the image");
    c = v4l2_config();
    c.unit_m = 0;
    refuse(&c, -EINVAL, "v4l2: unit is 0 m");
    assert_int_equal(kernel_n_mappings(), 1);
}

/* ---- probe --------------------------------------------------------------------------------------
 */

struct probed {
    char text[1000];
};

static void on_found(void *ctx, const struct dx_device_found *d)
{
    struct probed *p = ctx;
    size_t len = strlen(p->text);

    snprintf(p->text + len, sizeof(p->text) - len, "%s|%s|%s|%s|%s|%d\n", d->name, d->node,
             d->serial, d->place, d->yaml, d->access);
}

static void test_probe(void **state)
{
    struct probed p = {""};
    struct dx_err err;

    (void)state;
    assert_int_equal(dx_v4l2_driver.probe(on_found, &p, &err), 0);
    assert_string_equal(p.text, "");
    plug_d4xx();
    kernel_plug("video5", 3, "7 7", KERNEL_CAPTURE, V4L2_PIX_FMT_Y16, 0);
    assert_int_equal(dx_v4l2_driver.probe(on_found, &p, &err), 0);
    assert_string_equal(p.text,
                        "Depth One, Z16|/dev/video2|845112|pci-0000:00:14.0-usb-0:2:1.0|"
                        "serial: \"845112\"\n#fx: 425 # pixels: see config/sensors|0\n"
                        "Depth One, Y16|/dev/video5|7 7|pci-0000:00:14.0-usb-0:3:1.0|"
                        "port: \"1-3\"\nformat: Y16\n#fx: 425 # pixels: see config/sensors|0\n");
    kernel_unplug("video5", 3);
    p.text[0] = 0;
    kernel.refuse_open = true;
    assert_int_equal(dx_v4l2_driver.probe(on_found, &p, &err), 0);
    assert_non_null(strstr(p.text, "Depth One, perhaps depth|/dev/video2|845112|"));
    assert_non_null(
        strstr(p.text, "|serial: \"845112\"\n#fx: 425 # pixels: see config/sensors|-13\n"));
}

#define TEST(test) cmocka_unit_test_setup_teardown(test, kernel_set_up, kernel_tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(test_bring_up),     TEST(test_streaming),    TEST(test_padded_lines),
        TEST(test_multi_planar), TEST(test_no_copy),      TEST(test_clocks),
        TEST(test_choice),       TEST(test_another_node), TEST(test_bring_up_fails),
        TEST(test_bad_cameras),  TEST(test_probe),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
