/* The synthetic driver: the frames of dx_scene_cast, in whole or in parts, stamped and counted. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "drivers/synth/synth.h"
#include "tests/unit/scene_rig.h"

#include <errno.h>
#include <math.h>

/* A sink that keeps one frame and what was said about it. */
struct sink {
    struct dx_geometry *g;
    struct dx_plane plane;
    uint64_t frame;
    bool any, closing;
    unsigned n_geometries, n_parts, n_last;
    struct dx_frame_part part;
};

static int sink_geometry(void *ctx, struct dx_geometry *g, uint8_t attr_bytes)
{
    struct sink *s = ctx;

    dx_geometry_unref(s->g);
    dx_plane_fini(&s->plane);
    s->g = dx_geometry_ref(g);
    s->n_geometries++;
    return dx_plane_init(&s->plane, g->height, g->width, g->range_bytes, attr_bytes);
}

static struct dx_plane *sink_plane(void *ctx, uint64_t number)
{
    struct sink *s = ctx;

    if (s->closing)
        return NULL;
    if (!s->any || number != s->frame) {
        size_t n = dx_plane_n_dexels(&s->plane);

        memset(s->plane.range, 0, n * s->plane.range_bytes);
        memset(s->plane.attr, 0, n * s->plane.attr_bytes);
    }
    s->any = true;
    s->frame = number;
    return &s->plane;
}

static void sink_deliver(void *ctx, const struct dx_frame_part *part)
{
    struct sink *s = ctx;

    s->part = *part;
    s->n_parts++;
    s->n_last += part->last;
}

static struct dx_frame_sink sink_of(struct sink *s)
{
    return (struct dx_frame_sink){s, sink_geometry, sink_plane, sink_deliver};
}

static void sink_fini(struct sink *s)
{
    dx_geometry_unref(s->g);
    dx_plane_fini(&s->plane);
}

static void config_init(struct dx_synth_config *c, enum dx_scene scene)
{
    memset(c, 0, sizeof(*c));
    dx_scene_config_default(&c->scene, scene);
    c->scene.height = 60;
    c->scene.width = 100;
    c->scene.attr_bytes = 2;
    c->scene.sigma[0] = 0.004;
    c->scene.dropout = 0.02;
    c->scene.mixed = 0.5;
    c->fps = 10;
}

static struct dx_device *open_and_start(const struct dx_synth_config *c)
{
    struct dx_device *dev = NULL;
    struct dx_err err = {""};

    if (dx_synth_driver.open(&dev, c, &err) || dx_synth_driver.start(dev, &err))
        fail_msg("%s", err.text);
    return dev;
}

static void close_device(struct dx_device *dev)
{
    dx_synth_driver.stop(dev);
    dx_synth_driver.close(dev);
}

/* Reads and decodes one block. */
static int step(struct dx_device *dev, struct sink *s, struct dx_block *block)
{
    struct dx_frame_sink sink = sink_of(s);
    struct dx_err err = {""};
    int r = dx_synth_driver.read(dev, block, &err);

    return r ? r : dx_synth_driver.decode(dev, block, &sink, &err);
}

static void expect_frame(const struct sink *s, const struct dx_synth_config *c, uint64_t number)
{
    struct rig want = {.config = c->scene};

    rig_open(&want);
    rig_cast(&want, number);
    if (!same(&s->plane, &want.plane))
        fail_msg("%s: frame %llu is not what dx_scene_cast gives", dx_scene_name(c->scene.scene),
                 (unsigned long long)number);
    rig_close(&want);
}

static void frames_are_the_scenes(void **state)
{
    (void)state;
    for (unsigned scene = 0; scene < DX_N_SCENES; scene++) {
        struct dx_synth_config c;
        struct dx_device *dev;
        struct dx_block block;
        struct sink s = {0};

        config_init(&c, scene);
        c.n_frames = 4;
        dev = open_and_start(&c);
        for (uint64_t k = 0; k < 4; k++) {
            assert_int_equal(step(dev, &s, &block), 0);
            assert_int_equal(s.part.frame, k);
            assert_true(s.part.last && s.part.col0 == 0 && s.part.n_cols == 100);
            expect_frame(&s, &c, k);
        }
        assert_int_equal(step(dev, &s, &block), DX_DRIVER_E_EOF);
        assert_int_equal(step(dev, &s, &block), DX_DRIVER_E_EOF);
        assert_int_equal(s.n_geometries, 1);
        close_device(dev);
        sink_fini(&s);
    }
}

/* A block out of turn (a seek in a recording) gives its own frame, whatever came before. */
static void blocks_stand_alone(void **state)
{
    static const uint8_t order[] = {90, 3, 30, 31, 0};
    struct dx_synth_config c;
    struct dx_device *dev;
    struct sink s = {0};
    uint8_t bytes[16];
    struct dx_block block, other;
    struct dx_frame_sink sink = sink_of(&s);

    (void)state;
    config_init(&c, DX_SCENE_MOVING_BOX);
    dev = open_and_start(&c);
    assert_int_equal(step(dev, &s, &block), 0);
    assert_int_equal(block.len, sizeof(bytes));
    memcpy(bytes, block.bytes, sizeof(bytes));
    other = block;
    other.bytes = bytes;
    for (size_t k = 0; k < sizeof(order); k++) {
        bytes[0] = order[k];
        assert_int_equal(dx_synth_driver.decode(dev, &other, &sink, NULL), 0);
        assert_int_equal(s.part.frame, order[k]);
        expect_frame(&s, &c, order[k]);
    }
    close_device(dev);
    sink_fini(&s);
}

static void parts_make_the_frame(void **state)
{
    struct dx_synth_config c;
    struct dx_device *dev;
    struct dx_block block;
    struct sink s = {0};

    (void)state;
    config_init(&c, DX_SCENE_HALL);
    c.part_cols = 33; /* 33, 33, 33, 1 */
    dev = open_and_start(&c);
    for (uint64_t frame = 0; frame < 3; frame++) {
        for (uint32_t k = 0; k < 4; k++) {
            assert_int_equal(step(dev, &s, &block), 0);
            assert_int_equal(s.part.frame, frame);
            assert_int_equal(s.part.col0, 33 * k);
            assert_int_equal(s.part.n_cols, k < 3 ? 33 : 1);
            assert_int_equal(s.part.last, k == 3);
            assert_int_equal(s.part.stamp.device_ns, frame * 100000000 + 33000000 * k);
        }
        expect_frame(&s, &c, frame);
    }
    assert_int_equal(s.n_last, 3);
    close_device(dev);
    sink_fini(&s);
}

static void a_loop_counts_on(void **state)
{
    struct dx_synth_config c;
    struct dx_device *dev;
    struct dx_block block;
    struct sink s = {0};

    (void)state;
    config_init(&c, DX_SCENE_MOVING_BOX);
    c.n_frames = 3;
    c.loop = true;
    dev = open_and_start(&c);
    for (uint64_t k = 0; k < 8; k++) {
        assert_int_equal(step(dev, &s, &block), 0);
        assert_int_equal(s.part.frame, k);
        assert_int_equal(block.number, k);
        expect_frame(&s, &c, k % 3);
    }
    close_device(dev);
    sink_fini(&s);
}

static void stamps_are_simulated_time(void **state)
{
    struct dx_synth_config c;
    struct dx_device *dev;
    struct dx_block block;
    struct sink s = {0};
    uint64_t host = 0;

    (void)state;
    config_init(&c, DX_SCENE_CREASE);
    c.fps = 3;
    dev = open_and_start(&c);
    for (uint64_t k = 0; k < 5; k++) {
        assert_int_equal(step(dev, &s, &block), 0);
        assert_int_equal(block.stamp.clock_id, DX_CLOCK_DEVICE);
        assert_int_equal(block.stamp.device_ns, (k * 1000000000 + 1) / 3);
        assert_true(block.stamp.host_ns >= host);
        assert_string_equal(block.source, "crease");
        host = block.stamp.host_ns;
    }
    close_device(dev);
    sink_fini(&s);
}

static void a_closing_sink_stops_the_decode(void **state)
{
    struct dx_synth_config c;
    struct dx_device *dev;
    struct dx_block block;
    struct sink s = {.closing = true};

    (void)state;
    config_init(&c, DX_SCENE_STAIRS);
    dev = open_and_start(&c);
    assert_int_equal(step(dev, &s, &block), DX_DRIVER_E_AGAIN);
    assert_int_equal(s.n_parts, 0);
    close_device(dev);
    sink_fini(&s);
}

static void a_woken_read_comes_again(void **state)
{
    struct dx_synth_config c;
    struct dx_device *dev;
    struct dx_block block;
    struct sink s = {0};

    (void)state;
    config_init(&c, DX_SCENE_STAIRS);
    c.rate = 1;
    c.fps = 0.001; /* the second frame is a quarter of an hour away */
    dev = open_and_start(&c);
    assert_int_equal(step(dev, &s, &block), 0);
    for (int k = 0; k < 3; k++) {
        dx_synth_driver.wake(dev);
        assert_int_equal(step(dev, &s, &block), DX_DRIVER_E_AGAIN);
    }
    assert_int_equal(s.part.frame, 0);
    close_device(dev);
    sink_fini(&s);
}

static void foreign_blocks_are_corrupt(void **state)
{
    struct dx_synth_config c;
    struct dx_device *dev;
    struct dx_block block, bad;
    struct sink s = {0};
    struct dx_frame_sink sink = sink_of(&s);
    struct dx_err err = {""};
    uint8_t bytes[16];

    (void)state;
    config_init(&c, DX_SCENE_HALL);
    dev = open_and_start(&c);
    assert_int_equal(step(dev, &s, &block), 0);
    bad = block;
    for (bad.len = 0; bad.len < 16; bad.len++)
        assert_int_equal(dx_synth_driver.decode(dev, &bad, &sink, &err), DX_DRIVER_E_CORRUPT);
    memcpy(bytes, block.bytes, 16);
    bad.bytes = bytes;
    bytes[12] ^= 1;
    assert_int_equal(dx_synth_driver.decode(dev, &bad, &sink, &err), DX_DRIVER_E_CORRUPT);
    assert_non_null(strstr(err.text, "hash"));
    bytes[12] ^= 1;
    bytes[8] = 100; /* the width */
    assert_int_equal(dx_synth_driver.decode(dev, &bad, &sink, &err), DX_DRIVER_E_CORRUPT);
    assert_non_null(strstr(err.text, "100"));
    bytes[8] = 0;
    assert_int_equal(dx_synth_driver.decode(dev, &bad, &sink, &err), 0);
    close_device(dev);
    sink_fini(&s);
}

static void expect_refused(const struct dx_synth_config *c, const char *why)
{
    struct dx_device *dev = NULL;
    struct dx_err err = {""};

    assert_int_equal(dx_synth_driver.open(&dev, c, &err), -EINVAL);
    assert_null(dev);
    if (!strstr(err.text, why))
        fail_msg("'%s' does not say '%s'", err.text, why);
}

static void wrong_configurations_are_refused(void **state)
{
    struct dx_synth_config good, c;

    (void)state;
    config_init(&good, DX_SCENE_HALL);
    c = good, c.fps = 0;
    expect_refused(&c, "fps is 0");
    c = good, c.fps = NAN;
    expect_refused(&c, "fps");
    c = good, c.rate = -1;
    expect_refused(&c, "rate is -1");
    c = good, c.scene.dropout = 1.5;
    expect_refused(&c, "dropout is 1.5");
    c = good, c.scene.sigma[1] = -0.1;
    expect_refused(&c, "sigma");
    c = good, c.scene.width = 3;
    expect_refused(&c, "60 rows x 3 columns");
    dx_synth_driver.close(NULL);
}

static void the_description_names_the_scene(void **state)
{
    struct dx_synth_config c;
    struct dx_device *dev;
    char text[200];

    (void)state;
    config_init(&c, DX_SCENE_MOVING_BOX);
    dev = open_and_start(&c);
    dx_synth_driver.describe(dev, text, sizeof(text));
    assert_non_null(strstr(text, "moving-box: pinhole 60x100"));
    close_device(dev);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_are_the_scenes),
        cmocka_unit_test(blocks_stand_alone),
        cmocka_unit_test(parts_make_the_frame),
        cmocka_unit_test(a_loop_counts_on),
        cmocka_unit_test(stamps_are_simulated_time),
        cmocka_unit_test(a_closing_sink_stops_the_decode),
        cmocka_unit_test(a_woken_read_comes_again),
        cmocka_unit_test(foreign_blocks_are_corrupt),
        cmocka_unit_test(wrong_configurations_are_refused),
        cmocka_unit_test(the_description_names_the_scene),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
