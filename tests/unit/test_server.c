/* What the server tells well-behaved subscribers. */
#include "tests/unit/server_client.h"

static void test_late_joiner(void **state)
{
    struct fixture *fx = fixture_start(NULL);
    struct client *first = client_start(fx, NULL), *late;

    (void)state;
    client_until_frame(first, 3);
    assert_int_equal(first->n_commits, 1); /* the snapshot */
    for (uint64_t f = 4; f < 40; f++) {
        fixture_frames(fx, f);
        client_until_frame(first, f);
    }
    assert_int_equal(first->n_commits, 37);
    late = client_start(fx, NULL);
    client_until(late, DX_MSG_SNAPSHOT_END);
    assert_int_equal(late->n_commits, 1);
    assert_int_equal(late->commit.frame, 39);
    fixture_frames(fx, 45);
    client_until_frame(first, 45);
    client_until_frame(late, 45);
    assert_int_equal(first->n_resets, 0);
    assert_int_equal(late->n_resets, 0);
    client_close(first);
    client_close(late);
    fixture_stop(fx);
}

static void test_both_encodings(void **state)
{
    const struct dx_msg_subscribe q16 = {.encoding = DX_ENCODING_Q16, .stream = "test"};
    struct fixture *fx = fixture_start(NULL);
    struct client *a = client_start(fx, NULL), *b;

    (void)state;
    client_until_frame(a, 3);
    assert_int_equal(a->geometry_len, 0);
    b = client_start(fx, &q16); /* the stream is idle: the mesher encodes for it all the same */
    client_until_frame(b, 3);
    assert_int_equal(b->geometry_len, 4 * (100 + 180));
    fixture_frames(fx, 9);
    client_until_frame(a, 9);
    client_until_frame(b, 9);
    client_close(a);
    client_close(b);
    fixture_stop(fx);
}

/* A table of more bytes than a subscriber gets in two turns, on a stream where nothing else
 * happens: the loop must come back for the rest of it by itself. */
static void test_long_geometry_on_an_idle_stream(void **state)
{
    const struct dx_msg_subscribe q16 = {.encoding = DX_ENCODING_Q16, .stream = "test"};
    struct fixture *fx = fixture_start(&(struct fixture_options){.grid = 201});

    (void)state;
    for (int k = 0; k < 50; k++) {
        struct client *c = client_start(fx, &q16);

        client_until_frame(c, 3);
        assert_int_equal(c->geometry_len, 4 * 3 * 190 * 250);
        client_close(c);
    }
    fixture_stop(fx);
}

static void test_subscribed_before_the_geometry(void **state)
{
    struct fixture *fx = fixture_start(&(struct fixture_options){.no_mesh = true});
    struct client *c = client_start(fx, NULL);

    (void)state;
    client_until(c, DX_MSG_STREAM_STATE);
    assert_int_equal(c->state.state, DX_STREAM_OPENING);
    assert_int_equal(atomic_load(&fx->n_subscribers), 1);
    fixture_frames(fx, 1);
    client_until_frame(c, 1);
    assert_int_equal(c->n_resets, 0); /* it had been told nothing that could be reset */
    client_close(c);
    fixture_stop(fx);
}

static void test_ended_comes_last(void **state)
{
    const struct dx_msg_subscribe q16 = {.encoding = DX_ENCODING_Q16};
    struct fixture *fx = fixture_start(NULL);
    struct client *a = client_start(fx, NULL), *b;

    (void)state;
    client_until(a, DX_MSG_SNAPSHOT_END);
    fixture_frames(fx, 30);
    fixture_state(fx, DX_STREAM_ENDED);
    do
        client_until(a, DX_MSG_STREAM_STATE);
    while (a->state.state != DX_STREAM_ENDED);
    assert_int_equal(a->commit.frame, 30);
    b = client_start(fx, &q16); /* after the end, in an encoding nobody had asked for */
    do
        client_until(b, DX_MSG_STREAM_STATE);
    while (b->state.state != DX_STREAM_ENDED);
    assert_int_equal(b->commit.frame, 30);
    assert_int_equal(b->n_commits, 1);
    client_close(a);
    client_close(b);
    fixture_stop(fx);
}

static void test_ended_without_a_mesh(void **state)
{
    struct fixture *fx = fixture_start(&(struct fixture_options){.no_mesh = true});
    struct client *c = client_start(fx, NULL);

    (void)state;
    fixture_state(fx, DX_STREAM_ENDED);
    do
        client_until(c, DX_MSG_STREAM_STATE);
    while (c->state.state != DX_STREAM_ENDED);
    assert_string_equal(c->state.reason, "as the test says");
    client_close(c);
    fixture_stop(fx);
}

static void test_pull(void **state)
{
    const struct dx_msg_subscribe pull = {.mode = DX_MODE_PULL};
    struct fixture *fx = fixture_start(NULL);
    struct client *c = client_start(fx, &pull), *live = client_start(fx, NULL);

    (void)state;
    client_until(c, DX_MSG_SUBSCRIBED);
    fixture_frames(fx, 10);
    client_until_frame(live, 10);
    client_send(c, DX_MSG_NEXT, NULL, 0);
    client_until(c, DX_MSG_SNAPSHOT_END);
    assert_int_equal(c->commit.frame, 10); /* nothing came before it was asked for */
    assert_int_equal(c->n_commits, 1);
    fixture_frames(fx, 20);
    client_until_frame(live, 20);
    client_send(c, DX_MSG_NEXT, NULL, 0);
    client_until(c, DX_MSG_COMMIT);
    assert_int_equal(c->commit.frame, 20); /* all between are one */
    client_send(c, DX_MSG_NEXT, NULL, 0);  /* ahead of the epoch */
    fixture_frames(fx, 21);
    client_until_frame(c, 21);
    assert_int_equal(c->n_commits, 3);
    client_close(c);
    client_close(live);
    fixture_stop(fx);
}

static void test_region(void **state)
{
    const struct dx_msg_subscribe region = {
        .tile_row0 = 1, .tile_col0 = 1, .n_tile_rows = 9, .n_tile_cols = 1};
    struct fixture *fx = fixture_start(NULL);
    struct client *c = client_start(fx, &region);

    (void)state;
    client_until(c, DX_MSG_SNAPSHOT_END);
    for (uint64_t f = 4; f < 20; f++) { /* a COMMIT also for epochs without a tile of its own */
        fixture_frames(fx, f);
        client_until_frame(c, f);
    }
    assert_int_equal(c->n_commits, 17);
    client_close(c);
    fixture_stop(fx);
}

static void test_interval(void **state)
{
    const struct dx_msg_subscribe rare = {.min_interval_ms = 50};
    struct fixture *fx = fixture_start(NULL);
    struct client *c = client_start(fx, &rare), *live = client_start(fx, NULL);

    (void)state;
    client_until(c, DX_MSG_SNAPSHOT_END);
    client_until(live, DX_MSG_SNAPSHOT_END);
    for (uint64_t f = 4; f < 100; f++) {
        fixture_frames(fx, f);
        client_until_frame(live, f);
    }
    client_until_frame(c, 99); /* the last one is not lost when its time comes */
    assert_true(c->n_commits < live->n_commits);
    client_close(c);
    client_close(live);
    fixture_stop(fx);
}

static void test_lossless(void **state)
{
    const struct dx_msg_subscribe lossless = {.mode = DX_MODE_LOSSLESS};
    const struct dx_msg_subscribe lossless_q16 = {.mode = DX_MODE_LOSSLESS,
                                                  .encoding = DX_ENCODING_Q16};
    struct fixture *fx =
        fixture_start(&(struct fixture_options){.lossless = true, .no_mesh = true});
    struct client *a = client_start(fx, &lossless), *b = client_start(fx, &lossless_q16);

    (void)state;
    client_until(a, DX_MSG_STREAM_STATE);
    client_until(b, DX_MSG_STREAM_STATE);
    fixture_frames(fx, 200);
    for (uint64_t f = 1; f <= 200; f++) {
        client_until(a, DX_MSG_COMMIT);
        assert_int_equal(a->commit.frame, f);
        client_until(b, DX_MSG_COMMIT);
        assert_int_equal(b->commit.frame, f);
    }
    client_close(a); /* the mesher goes on for the other, and then for nobody */
    fixture_frames(fx, 300);
    client_until_frame(b, 300);
    client_close(b);
    fixture_frames(fx, 400);
    a = client_start(fx, NULL);
    client_until_frame(a, 400);
    client_close(a);
    fixture_stop(fx);
}

/* More tiles than the outbox has messages, more bytes than a turn has, and several clients at once.
 */
static void test_long_batches(void **state)
{
    const struct dx_msg_subscribe lossless = {.mode = DX_MODE_LOSSLESS};
    struct fixture *fx = fixture_start(
        &(struct fixture_options){.lossless = true,
                                  .no_mesh = true,
                                  .grid = 2,
                                  .body_len = 20000,
                                  .server = {.stall_ns = 600000000000u}}); /* some wait long */
    struct client *c[4];

    (void)state;
    for (int k = 0; k < 4; k++)
        c[k] = client_start(fx, k % 2 ? &lossless : NULL);
    for (int k = 0; k < 4; k++)
        client_until(c[k], DX_MSG_STREAM_STATE);
    fixture_frames(fx, 40);
    for (uint64_t f = 1; f <= 40; f++)
        for (int k = 1; k < 4; k += 2) {
            client_until(c[k], DX_MSG_COMMIT);
            assert_int_equal(c[k]->commit.frame, f);
        }
    client_until_frame(c[0], 40);
    client_until_frame(c[2], 40);
    for (int k = 0; k < 4; k++)
        client_close(c[k]);
    fixture_stop(fx);
}

static void test_new_geometry(void **state)
{
    const struct dx_msg_subscribe q16 = {.encoding = DX_ENCODING_Q16};
    const struct dx_msg_subscribe delta = {.encoding = DX_ENCODING_DELTA};
    struct fixture *fx = fixture_start(NULL);
    struct client *a = client_start(fx, NULL), *b = client_start(fx, &q16);
    struct client *c = client_start(fx, &delta);

    (void)state;
    client_until_frame(a, 3);
    client_until_frame(b, 3);
    client_until_frame(c, 3);
    atomic_store(&fx->grid, 1);
    fixture_kick(fx);
    client_until(a, DX_MSG_RESET);
    assert_string_equal(a->reset.reason, "another geometry");
    client_until_frame(a, 3);
    client_until(b, DX_MSG_RESET);
    client_until_frame(b, 3);
    assert_int_equal(a->told.height, 190);
    assert_int_equal(b->geometry_len, 4 * (190 + 250));
    fixture_frames(fx, 8);
    client_until_frame(a, 8);
    client_until_frame(b, 8);
    atomic_store(&fx->grid, 100); /* 32-bit ranges */
    fixture_kick(fx);
    client_until(a, DX_MSG_RESET);
    client_until_frame(a, 8);
    client_expect_error(b, DX_WIRE_E_ENCODING);
    while (c->told.range_bytes != 4) /* the grid before this one may come first, or not at all */
        client_until(c, DX_MSG_SUBSCRIBED);
    client_until_frame(c, 8);
    assert_int_equal(c->geometry_len, 4 * (100 + 180));
    client_close(a);
    client_close(c);
    fixture_stop(fx);
}

/* Each client gets the sections that it asked for, cut out of one chunk. */
static void sections_on_request(uint8_t attr_bytes, bool normals)
{
    struct fixture *fx = fixture_start(
        &(struct fixture_options){.attr_bytes = attr_bytes, .normals = normals, .body_len = 9000});
    struct client *c[4];

    for (uint8_t want = 0; want < 4; want++) {
        const struct dx_msg_subscribe m = {.want = want, .encoding = want % DX_N_ENCODINGS};

        c[want] = client_start(fx, &m);
        client_until_frame(c[want], 3);
        assert_int_equal(c[want]->told.attr_bytes, want & DX_WANT_ATTR ? attr_bytes : 0);
        assert_int_equal(c[want]->told.normals, want & DX_WANT_NORMALS && normals);
    }
    fixture_frames(fx, 12);
    for (int want = 0; want < 4; want++) {
        client_until_frame(c[want], 12);
        client_close(c[want]);
    }
    fixture_stop(fx);
}

static void test_sections_on_request(void **state)
{
    (void)state;
    sections_on_request(1, false);
    sections_on_request(2, true);
    sections_on_request(0, true);
}

static void test_stop_is_told(void **state)
{
    struct fixture *fx = fixture_start(NULL);
    struct client *c = client_start(fx, NULL);

    (void)state;
    client_until_frame(c, 3);
    dx_server_stop(fx->server);
    fixture_join_server(fx);
    client_expect_error(c, DX_WIRE_E_SHUTDOWN);
    fixture_stop(fx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_late_joiner),
        cmocka_unit_test(test_both_encodings),
        cmocka_unit_test(test_long_geometry_on_an_idle_stream),
        cmocka_unit_test(test_subscribed_before_the_geometry),
        cmocka_unit_test(test_ended_comes_last),
        cmocka_unit_test(test_ended_without_a_mesh),
        cmocka_unit_test(test_pull),
        cmocka_unit_test(test_region),
        cmocka_unit_test(test_interval),
        cmocka_unit_test(test_lossless),
        cmocka_unit_test(test_long_batches),
        cmocka_unit_test(test_new_geometry),
        cmocka_unit_test(test_sections_on_request),
        cmocka_unit_test(test_stop_is_told),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
