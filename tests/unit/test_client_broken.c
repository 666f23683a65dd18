/*
 * libdexel against servers that are broken, lie, refuse or leave: each must end in an error with a
 * text that says why, and never in harm.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "tests/unit/client_fixture.h"

/* One wrong thing after a good start; what the client must answer, and a word of its text. */
static void refuse_case(const char *name, void (*say)(struct script *, const struct dx_geometry *),
                        const char *word)
{
    struct dx_geometry *g = fixture_small_geometry();
    struct session s;
    int r;

    open_session(&s, (struct dexel_options){.encoding = DEXEL_Q16}, &callbacks);
    say(&s.script, g);
    r = play(&s, SIZE_MAX);
    if (r != -EPROTO || !strstr(dexel_error(s.client), word))
        fail_msg("%s: %d, %s", name, r, dexel_error(s.client));
    assert_int_equal(dexel_dispatch(s.client), -EPROTO);
    assert_int_equal(dexel_next(s.client), -EPROTO);
    close_session(&s);
    dx_geometry_unref(g);
}

static void say_wrong_magic(struct script *s, const struct dx_geometry *g)
{
    (void)g;
    script_welcome(s);
    s->bytes[DX_WIRE_HEADER_LEN] = 'X';
}

static void say_another_version(struct script *s, const struct dx_geometry *g)
{
    (void)g;
    script_welcome(s);
    s->bytes[DX_WIRE_HEADER_LEN + 4] = 9;
}

/* It may not choose more than HELLO said. */
static void say_later_minor(struct script *s, const struct dx_geometry *g)
{
    (void)g;
    script_welcome(s);
    s->bytes[DX_WIRE_HEADER_LEN + 6] = DX_WIRE_MINOR + 1;
}

static void say_http(struct script *s, const struct dx_geometry *g)
{
    (void)g;
    script_message(s, 0, 0, 0, NULL, 0);
    memcpy(s->bytes, "HTTP/1.1 400 Bad Request", 24);
}

/* The control socket does, when it meets a HELLO. */
static void say_json(struct script *s, const struct dx_geometry *g)
{
    (void)g;
    script_message(s, 0, 0, 0, NULL, 0);
    memcpy(s->bytes, "{\"error\":\"found a control", 24);
}

static void say_oversized(struct script *s, const struct dx_geometry *g)
{
    start(s, g);
    script_message(s, DX_MSG_TILE, 0, 1, NULL, 0);
    dx_put_u32(s->bytes + s->len - DX_WIRE_HEADER_LEN, DX_WIRE_MAX_BODY + 1);
}

static void say_greedy_welcome(struct script *s, const struct dx_geometry *g)
{
    (void)g;
    script_welcome(s);
    dx_put_u32(s->bytes + DX_WIRE_HEADER_LEN + 16, 0xffffffff);
}

static void say_lost_message(struct script *s, const struct dx_geometry *g)
{
    start(s, g);
    s->seq++;
    script_commit(s, 1, 0);
}

static void say_error(struct script *s, const struct dx_geometry *g)
{
    (void)g;
    script_welcome(s);
    script_error(s, DX_WIRE_E_NO_STREAM, "no stream 'roof'; there are: cellar");
}

static void say_unknown_type(struct script *s, const struct dx_geometry *g)
{
    start(s, g);
    script_message(s, 999, 0, 0, "abc", 3);
}

static void say_data_before_welcome(struct script *s, const struct dx_geometry *g)
{
    small_tile(s, g, DX_ENCODING_Q16, 1, 0);
}

static void say_data_before_geometry(struct script *s, const struct dx_geometry *g)
{
    struct dx_msg_subscribed m;

    script_welcome(s);
    fixture_subscribed(&m, g, DX_ENCODING_Q16, 0);
    SCRIPT_PUT(s, DX_MSG_SUBSCRIBED, subscribed, &m);
    script_message(s, DX_MSG_SNAPSHOT_BEGIN, 0, 1, NULL, 0);
}

static void say_geometry_gap(struct script *s, const struct dx_geometry *g)
{
    static const uint8_t bytes[4];
    const struct dx_msg_geometry piece = {
        .offset = 4, .total = (uint32_t)(4 * g->n_table), .len = 4, .bytes = bytes};
    struct dx_msg_subscribed m;

    script_welcome(s);
    fixture_subscribed(&m, g, DX_ENCODING_Q16, 0);
    SCRIPT_PUT(s, DX_MSG_SUBSCRIBED, subscribed, &m);
    SCRIPT_PUT(s, DX_MSG_GEOMETRY, geometry, &piece);
}

static void say_other_encoding(struct script *s, const struct dx_geometry *g)
{
    script_welcome(s);
    script_subscribed(s, g, DX_ENCODING_F32, 0);
}

static void say_f32_tile(struct script *s, const struct dx_geometry *g)
{
    start(s, g);
    small_tile(s, g, DX_ENCODING_F32, 1, 0);
}

static void say_normals_tile(struct script *s, const struct dx_geometry *g)
{
    struct dx_tiling t;
    struct dx_tile tile;

    start(s, g);
    dx_tiling_init(&t, 3, 3, false);
    fixture_small_tile(&tile);
    tile.has_normals = true;
    script_tile(s, DX_ENCODING_Q16, 1, &tile, &t, g);
}

static void say_attr_tile(struct script *s, const struct dx_geometry *g)
{
    start(s, g);
    small_tile(s, g, DX_ENCODING_Q16, 1, 1);
}

static void say_broken_tile(struct script *s, const struct dx_geometry *g)
{
    start(s, g);
    small_tile(s, g, DX_ENCODING_Q16, 1, 0);
    s->bytes[s->len - 16] = 0xff; /* the codes */
}

static void say_mixed_epochs(struct script *s, const struct dx_geometry *g)
{
    start(s, g);
    small_tile(s, g, DX_ENCODING_Q16, 1, 0);
    small_tile(s, g, DX_ENCODING_Q16, 2, 0);
}

static void say_wrong_count(struct script *s, const struct dx_geometry *g)
{
    start(s, g);
    small_tile(s, g, DX_ENCODING_Q16, 1, 0);
    script_commit(s, 1, 2);
}

static void say_another_stream(struct script *s, const struct dx_geometry *g)
{
    start(s, g);
    script_commit(s, 1, 0);
    dx_put_u32(s->bytes + s->len - 44 - 16, 2);
}

static void say_snapshot_twice(struct script *s, const struct dx_geometry *g)
{
    start(s, g);
    script_message(s, DX_MSG_SNAPSHOT_BEGIN, 0, 1, NULL, 0);
}

static void say_state_in_batch(struct script *s, const struct dx_geometry *g)
{
    start(s, g);
    small_tile(s, g, DX_ENCODING_Q16, 1, 0);
    script_state(s, DX_STREAM_LIVE, "");
}

/* Smoothed, of a stream that is not. */
static void say_smoothed_tile(struct script *s, const struct dx_geometry *g)
{
    size_t at;

    start(s, g);
    at = s->len;
    small_tile(s, g, DX_ENCODING_Q16, 1, 0);
    dx_chunk_set_smoothed(s->bytes + at + DX_WIRE_HEADER_LEN);
}

static void test_broken_servers(void **state)
{
    (void)state;
    refuse_case("wrong magic", say_wrong_magic, "not a WELCOME");
    refuse_case("another version", say_another_version, "expected 1.0 or less");
    refuse_case("a later minor", say_later_minor, "speaks protocol 1.1");
    refuse_case("http", say_http, "at most 1024");
    refuse_case("JSON", say_json, "this seems to be the control socket");
    refuse_case("oversized", say_oversized, "262145");
    refuse_case("greedy welcome", say_greedy_welcome, "not a WELCOME");
    refuse_case("lost message", say_lost_message, "numbered");
    refuse_case("ERROR", say_error, "no stream 'roof'");
    refuse_case("unknown type", say_unknown_type, "unknown type 999");
    refuse_case("data before WELCOME", say_data_before_welcome, "TILE out of order");
    refuse_case("data before GEOMETRY", say_data_before_geometry, "out of order");
    refuse_case("gap in GEOMETRY", say_geometry_gap, "bytes from 4");
    refuse_case("another encoding", say_other_encoding, "encoding");
    refuse_case("f32 tile", say_f32_tile, "encoding");
    refuse_case("attributes", say_attr_tile, "attribute");
    refuse_case("normals", say_normals_tile, "normals");
    refuse_case("broken tile", say_broken_tile, "TILE");
    refuse_case("smoothed tile", say_smoothed_tile, "smoothed");
    refuse_case("mixed epochs", say_mixed_epochs, "epoch");
    refuse_case("wrong count", say_wrong_count, "COMMIT");
    refuse_case("another stream", say_another_stream, "of stream 2");
    refuse_case("snapshot twice", say_snapshot_twice, "out of order");
    refuse_case("state in a batch", say_state_in_batch, "inside a batch");
}

static void test_early_close(void **state)
{
    struct dx_geometry *g = fixture_small_geometry();
    struct script all = {0};

    (void)state;
    start(&all, g);
    small_tile(&all, g, DX_ENCODING_Q16, 1, 0);
    for (size_t n = 0; n < all.len; n += 7) {
        struct session s;

        open_session(&s, (struct dexel_options){.encoding = DEXEL_Q16}, &callbacks);
        assert_true(send(s.server, all.bytes, n, 0) == (ssize_t)n);
        hang_up(&s);
        assert_int_equal(dexel_run(s.client, -1), -ECONNRESET);
        assert_non_null(strstr(dexel_error(s.client), "closed the connection"));
        close_session(&s);
    }
    free(all.bytes);
    dx_geometry_unref(g);
}

/* The server refused and left before we wrote: its reason must still be read. */
static void test_error_then_close(void **state)
{
    struct session s;

    (void)state;
    open_session(&s, (struct dexel_options){.mode = DEXEL_PULL}, &callbacks);
    script_error(&s.script, DX_WIRE_E_LIMIT, "64 subscribers already");
    assert_true(send(s.server, s.script.bytes, s.script.len, 0) == (ssize_t)s.script.len);
    hang_up(&s);
    assert_int_equal(dexel_next(s.client), 0);
    assert_int_equal(dexel_run(s.client, -1), -EPROTO);
    assert_non_null(strstr(dexel_error(s.client), "64 subscribers already"));
    close_session(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_broken_servers),
        cmocka_unit_test(test_early_close),
        cmocka_unit_test(test_error_then_close),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
