/* What the status tells of a stream whose source is a device. The reader does not run. */
#include "fake_driver.h"

#include "daemon/clock.h"
#include "daemon/reader.h"
#include "daemon/server_priv.h"
#include "daemon/status.h"
#include "drivers/gpio/gpio_script.h"
#include "drivers/rig.h"

static void kick(void *ctx)
{
    (void)ctx;
}

static json_t *status_of(struct dx_server *server)
{
    json_t *o = dx_status(server, false), *streams = json_object_get(o, "streams");
    json_t *d = json_incref(json_object_get(json_array_get(streams, 0), "device"));

    json_decref(o);
    return d;
}

static const char *text(const json_t *o, const char *key)
{
    return json_string_value(json_object_get(o, key));
}

/* A server with a stream of the fake device, whose reader does not run. */
struct bench {
    struct dx_server *server;
    struct dx_server_stream_options stream;
    struct dx_counters counters;
    struct dx_feed *feed;
    struct dx_mailbox *mailbox;
};

static int setup(void **state)
{
    static struct bench b;
    const struct dx_server_options options = {0};
    struct dx_err err = {""};

    b = (struct bench){.stream = {.name = "t"}};
    fake = (struct fake_world){.present = true, .serial = 7};
    assert_int_equal(dx_mailbox_new(&b.mailbox, false, kick, NULL), 0);
    assert_int_equal(dx_feed_new(&b.feed, 4, 6, 2, -1, kick, NULL), 0);
    assert_int_equal(dx_stream_reader_new(&b.stream.reader, "t", &fake_driver, NULL, b.mailbox,
                                          &b.counters, &err),
                     0);
    assert_int_equal(dx_server_new(&b.server, &options, &err), 0);
    b.stream.feed = b.feed;
    b.stream.counters = &b.counters;
    assert_int_equal(dx_server_add_stream(b.server, &b.stream), 0);
    *state = &b;
    return 0;
}

static int teardown(void **state)
{
    struct bench *b = *state;

    dx_server_free(b->server);
    dx_stream_reader_free(b->stream.reader);
    dx_feed_free(b->feed);
    dx_mailbox_free(b->mailbox);
    return 0;
}

static void tells_of_the_device(void **state)
{
    const struct bench *b = *state;
    struct dx_reader_device *reader = dx_stream_reader_attached(b->stream.reader);
    struct dx_block block;
    json_t *d = status_of(b->server);

    assert_string_equal(text(d, "state"), "opening");
    assert_string_equal(text(d, "serial"), "");
    assert_null(json_object_get(d, "gpio")); /* it has no lines */
    json_decref(d);
    while (dx_reader_device_read(reader, &block) != 0)
        ;
    d = status_of(b->server);
    assert_string_equal(text(d, "state"), "streaming");
    assert_string_equal(text(d, "serial"), "F7");
    assert_string_equal(text(d, "place"), "nowhere");
    assert_null(json_object_get(d, "reason"));
    assert_int_equal(json_integer_value(json_object_get(d, "opens")), 1);
    json_decref(d);
    fake.present = false;
    while (dx_reader_device_streams(reader))
        dx_reader_device_read(reader, &block);
    d = status_of(b->server);
    assert_string_equal(text(d, "state"), "gone");
    assert_string_equal(text(d, "reason"), "the fake was unplugged");
    assert_string_equal(text(d, "serial"), "F7"); /* still: that is what is missed */
    assert_int_equal(json_integer_value(json_object_get(d, "unplugged")), 1);
    assert_int_equal(json_integer_value(json_object_get(d, "lost")), 3);
    json_decref(d);
}

/* Waits until the lines are told so; they have a thread of their own. */
static json_t *lines_when(struct dx_server *server, const char *key, bool is_so)
{
    for (;;) {
        json_t *d = status_of(server);
        json_t *lines = json_incref(json_object_get(d, "gpio"));

        json_decref(d);
        assert_non_null(lines);
        if (json_is_true(json_object_get(lines, key)) == is_so)
            return lines;
        json_decref(lines);
        poll(NULL, 0, 1);
    }
}

static void tells_of_the_lines_about_it(void **state)
{
    static char interlock[] = "gpiochip0:1", laser[] = "gpiochip0:2";
    static const struct dx_rig_config config = {
        .interlock = {.line = interlock, .active_low = true, .bias = DX_GPIO_PULL_DOWN},
        .laser = {.line = laser},
    };
    const struct bench *b = *state;
    struct dx_reader_device *reader = dx_stream_reader_attached(b->stream.reader);
    struct dx_gpio_script *script;
    struct dx_block block;
    struct dx_rig *rig;
    json_t *lines;

    assert_int_equal(dx_gpio_script_new(&script, NULL, 0, NULL), 0);
    assert_int_equal(dx_rig_open_on(&rig, &config, dx_gpio_script_bank(script), NULL), 0);
    dx_reader_device_rig(reader, rig);
    lines = lines_when(b->server, "lines", true);
    assert_true(json_is_false(json_object_get(lines, "laser")));
    assert_int_equal(json_integer_value(json_object_get(lines, "interlock_openings")), 0);
    assert_null(json_object_get(lines, "pps_offset_us")); /* there is none */
    json_decref(lines);
    while (dx_reader_device_read(reader, &block) != 0)
        ;
    json_decref(lines_when(b->server, "laser", true));
    dx_gpio_script_set_level(script, 0, true, dx_clock_ns());
    lines = lines_when(b->server, "interlock_open", true);
    assert_int_equal(json_integer_value(json_object_get(lines, "interlock_openings")), 1);
    json_decref(lines);
    json_decref(lines_when(b->server, "laser", false));
    dx_reader_device_close(reader);
    dx_reader_device_rig(reader, NULL);
    dx_rig_close(rig);
    dx_gpio_script_free(script);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(tells_of_the_device, setup, teardown),
        cmocka_unit_test_setup_teardown(tells_of_the_lines_about_it, setup, teardown),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
