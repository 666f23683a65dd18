/* What the status tells of a stream whose source is a device. The reader does not run. */
#include "fake_driver.h"

#include "daemon/reader.h"
#include "daemon/server_priv.h"
#include "daemon/status.h"

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

static void tells_of_the_device(void **state)
{
    const struct dx_server_options options = {0};
    struct dx_server_stream_options stream = {.name = "t"};
    struct dx_counters counters = {0};
    struct dx_server *server = NULL;
    struct dx_feed *feed = NULL;
    struct dx_mailbox *mailbox = NULL;
    struct dx_block block;
    struct dx_err err = {""};
    json_t *d;

    (void)state;
    fake = (struct fake_world){.present = true, .serial = 7};
    assert_int_equal(dx_mailbox_new(&mailbox, false, kick, NULL), 0);
    assert_int_equal(dx_feed_new(&feed, 4, 6, 2, -1, kick, NULL), 0);
    assert_int_equal(
        dx_stream_reader_new(&stream.reader, "t", &fake_driver, NULL, mailbox, &counters, &err), 0);
    assert_int_equal(dx_server_new(&server, &options, &err), 0);
    stream.feed = feed;
    stream.counters = &counters;
    assert_int_equal(dx_server_add_stream(server, &stream), 0);
    d = status_of(server);
    assert_string_equal(text(d, "state"), "opening");
    assert_string_equal(text(d, "serial"), "");
    json_decref(d);
    while (dx_reader_device_read(dx_stream_reader_attached(stream.reader), &block) != 0)
        ;
    d = status_of(server);
    assert_string_equal(text(d, "state"), "streaming");
    assert_string_equal(text(d, "serial"), "F7");
    assert_string_equal(text(d, "place"), "nowhere");
    assert_null(json_object_get(d, "reason"));
    assert_int_equal(json_integer_value(json_object_get(d, "opens")), 1);
    json_decref(d);
    fake.present = false;
    while (dx_reader_device_streams(dx_stream_reader_attached(stream.reader)))
        dx_reader_device_read(dx_stream_reader_attached(stream.reader), &block);
    d = status_of(server);
    assert_string_equal(text(d, "state"), "gone");
    assert_string_equal(text(d, "reason"), "the fake was unplugged");
    assert_string_equal(text(d, "serial"), "F7"); /* still: that is what is missed */
    assert_int_equal(json_integer_value(json_object_get(d, "unplugged")), 1);
    assert_int_equal(json_integer_value(json_object_get(d, "lost")), 3);
    json_decref(d);
    dx_server_free(server);
    dx_stream_reader_free(stream.reader);
    dx_feed_free(feed);
    dx_mailbox_free(mailbox);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(tells_of_the_device)};

    return cmocka_run_group_tests(tests, NULL, NULL);
}
