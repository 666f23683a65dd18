/* Streams that are replaced, removed and added under their subscribers, while the loop runs. */
#include "tests/unit/control_ask.h"

enum act { REPLACE, REMOVE, ADD };

/* A change, made on the loop's thread: it is what a reload asks for. */
struct change {
    enum act act;
    struct dx_server **server;
    struct dx_server_stream *stream; /* to be put; afterwards the one that was given up */
    sem_t done;
};

/* Another stream: a feed whose mesher is the test's own thread. */
struct other {
    struct fixture fx;
    struct mesher mesher;
};

static uint64_t make_change(void *ctx)
{
    struct change *c = ctx;

    if (c->act == REMOVE) {
        c->stream = dx_server_take_stream(*c->server, "test", "gone from the test");
    } else {
        assert_int_equal(dx_server_attach_stream(*c->server, c->stream), 0);
        c->stream = dx_server_put_stream(*c->server, c->stream, "configuration changed");
    }
    sem_post(&c->done);
    return 1;
}

static struct fixture *start(struct change *c, const struct fixture_options *options)
{
    struct fixture_options o = options ? *options : (struct fixture_options){0};
    struct fixture *fx;

    memset(c, 0, sizeof(*c));
    sem_init(&c->done, 0, 0);
    o.server.reload = make_change;
    o.server.ctx = c;
    fx = fixture_start(&o);
    c->server = &fx->server;
    return fx;
}

static void change(struct fixture *fx, struct change *c, enum act act,
                   struct dx_server_stream *stream)
{
    int fd = client_socket(fx->control, 0);

    c->act = act;
    c->stream = stream;
    assert_int_equal(send(fd, "{\"request\":\"reload\"}\n", 21, MSG_NOSIGNAL), 21);
    sem_wait(&c->done);
    close(fd);
    dx_server_stream_free(c->stream); /* beside the loop, which has let go of it */
}

static struct other *other_new(uint32_t grid, bool lossless)
{
    struct other *o = calloc(1, sizeof(*o));

    o->fx.body_len = 300;
    o->fx.lossless = lossless;
    sem_init(&o->fx.wake, 0, 0);
    atomic_store(&o->fx.grid, grid);
    atomic_store(&o->fx.state, -1);
    assert_int_equal(
        dx_feed_new_sized(&o->fx.feed, MAX_TILES, 16384, 2048, 64, -1, fixture_kick, &o->fx), 0);
    o->mesher.fx = &o->fx;
    return o;
}

static struct dx_server_stream *other_stream(struct other *o, const char *name)
{
    struct dx_server_stream *stream;

    assert_int_equal(dx_server_stream_new(
                         &stream, &(struct dx_server_stream_options){.name = name,
                                                                     .feed = o->fx.feed,
                                                                     .counters = &o->fx.counters,
                                                                     .lossless = o->fx.lossless,
                                                                     .subscribers = fixture_count,
                                                                     .ctx = &o->fx}),
                     0);
    return stream;
}

/* Up to frame n, as the mesher of its own does. */
static void other_frames(struct other *o, uint64_t n)
{
    atomic_store(&o->fx.target, n);
    if (!o->mesher.announced)
        mesher_announce(&o->mesher);
    while (o->mesher.frame < n || mesher_publish(&o->mesher))
        mesher_publish(&o->mesher);
}

static void other_free(struct other *o)
{
    dx_feed_free(o->fx.feed);
    sem_destroy(&o->fx.wake);
    free(o);
}

static void test_replaced(void **state)
{
    const struct dx_msg_subscribe q16 = {.encoding = DX_ENCODING_Q16},
                                  lod = {.lod = {.bound = 32, .stride = 4}};
    const struct dx_msg_subscribe *const asked[] = {NULL, &q16, &lod};
    struct change c;
    struct fixture *fx = start(&c, NULL);
    struct other *other = other_new(1, false);
    struct client *client[3], *late;

    (void)state;
    for (int k = 0; k < 3; k++) {
        client[k] = client_start(fx, asked[k]);
        client_until_frame(client[k], 3);
    }
    change(fx, &c, REPLACE, other_stream(other, "test"));
    assert_int_equal(atomic_load(&fx->n_subscribers), 0);
    assert_int_equal(atomic_load(&other->fx.n_subscribers), 3);
    for (int k = 0; k < 3; k++) {
        client_until(client[k], DX_MSG_RESET);
        assert_string_equal(client[k]->reset.reason, "configuration changed");
    }
    fixture_frames(fx, 9); /* the old mesher goes on for a while, and nobody sees it */
    other_frames(other, 5);
    for (int k = 0; k < 3; k++) {
        client_until_frame(client[k], 5);
        assert_int_equal(client[k]->told.height, fixture_grid(1)->height);
        assert_int_equal(client[k]->n_resets, 1);
    }
    late = client_start(fx, NULL);
    client_until(late, DX_MSG_STREAM_STATE);
    other_frames(other, 8);
    client_until_frame(late, 8);
    for (int k = 0; k < 3; k++) {
        client_until_frame(client[k], 8);
        client_close(client[k]);
    }
    client_close(late);
    fixture_stop(fx);
    other_free(other);
}

/* As status tells it, of the only client. */
static double lag_s(const struct fixture *fx)
{
    int fd = client_socket(fx->control, 0);
    json_t *reply = control_ask(fd, "{\"request\":\"status\"}\n");
    const json_t *client = json_array_get(json_object_get(reply, "clients"), 0);
    double lag = json_number_value(json_object_get(client, "lag_s"));

    assert_true(json_is_number(json_object_get(client, "lag_s")));
    json_decref(reply);
    close(fd);
    return lag;
}

/* In the middle of a long snapshot: what has begun to go out is finished, and then RESET comes. */
static void test_replaced_in_a_batch(void **state)
{
    struct change c;
    struct fixture *fx = start(&c, &(struct fixture_options){.grid = 2, .body_len = 60000});
    struct other *other = other_new(0, false);
    struct client *client = client_start(fx, NULL);

    (void)state;
    client_until(client, DX_MSG_TILE);
    assert_true(lag_s(fx) > 0);
    change(fx, &c, REPLACE, other_stream(other, "test"));
    client_until(client, DX_MSG_RESET);
    assert_int_equal(client->n_commits, 0);
    assert_true(lag_s(fx) == 0); /* there is no mesh that it has not */
    client->fx = &other->fx;
    other_frames(other, 4);
    client_until_frame(client, 4);
    assert_int_equal(client->n_resets, 1);
    client_close(client);
    fixture_stop(fx);
    other_free(other);
}

static void test_replaced_before_a_mesh(void **state)
{
    struct change c;
    struct fixture *fx = start(&c, &(struct fixture_options){.no_mesh = true});
    struct other *other = other_new(1, false);
    struct client *client = client_start(fx, NULL);

    (void)state;
    client_until(client, DX_MSG_STREAM_STATE);
    change(fx, &c, REPLACE, other_stream(other, "test"));
    other_frames(other, 2);
    client_until_frame(client, 2);
    assert_int_equal(client->n_resets, 0); /* it had been told nothing */
    client_close(client);
    fixture_stop(fx);
    other_free(other);
}

static void test_pull_and_lossless(void **state)
{
    const struct dx_msg_subscribe pull = {.mode = DX_MODE_PULL},
                                  lossless = {.mode = DX_MODE_LOSSLESS};
    struct change c;
    struct fixture *fx = start(&c, &(struct fixture_options){.lossless = true});
    struct other *first = other_new(1, true), *second = other_new(0, false);
    struct client *a = client_start(fx, &pull), *b = client_start(fx, &lossless);

    (void)state;
    client_until_frame(b, 3);
    client_until(a, DX_MSG_SUBSCRIBED);
    change(fx, &c, REPLACE, other_stream(first, "test"));
    client_until(b, DX_MSG_RESET);
    other_frames(first, 1);
    client_send(a, DX_MSG_NEXT, NULL, 0);
    client_until_frame(a, 1);
    client_until_frame(b, 1);
    change(fx, &c, REPLACE, other_stream(second, "test"));
    client_expect_error(b, DX_WIRE_E_MODE); /* what it asked for is no more to be had */
    client_until(a, DX_MSG_RESET);
    client_close(a);
    fixture_stop(fx);
    other_free(first);
    other_free(second);
}

/* Whoever names none is told which there are. */
static void expect_to_name_one(struct fixture *fx, const char *names)
{
    struct client *client = client_start(fx, NULL);
    char text[DX_WIRE_TEXT];

    client_until_closed(client);
    assert_int_equal(client->error.code, DX_WIRE_E_NO_STREAM);
    snprintf(text, sizeof(text), "no stream was named, and there are several: %s", names);
    assert_string_equal(client->error.text, text);
    client_close(client);
}

static void test_removed_and_added(void **state)
{
    const struct dx_msg_subscribe named = {.stream = "second"};
    struct change c;
    struct fixture *fx = start(&c, NULL);
    struct other *other = other_new(1, false);
    struct client *client = client_start(fx, NULL), *stays = client_start(fx, &named);
    uint32_t number;

    (void)state;
    client_until_frame(client, 3);
    client_expect_error(stays, DX_WIRE_E_NO_STREAM);
    number = client->n_commits;
    change(fx, &c, ADD, other_stream(other, "second"));
    stays = client_start(fx, &named);
    client_until(stays, DX_MSG_STREAM_STATE);
    other_frames(other, 2);
    client_until_frame(stays, 2);
    assert_int_equal(client->n_commits, number);
    expect_to_name_one(fx, "test, second");
    change(fx, &c, REMOVE, NULL);
    client_until_closed(client);
    assert_int_equal(client->error.code, DX_WIRE_E_NO_STREAM);
    assert_string_equal(client->error.text, "gone from the test");
    client_close(client);
    other_frames(other, 4);
    client_until_frame(stays, 4);
    assert_int_equal(stays->n_resets, 0);
    client_close(stays);
    fixture_stop(fx);
    other_free(other);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_replaced),
        cmocka_unit_test(test_replaced_in_a_batch),
        cmocka_unit_test(test_replaced_before_a_mesh),
        cmocka_unit_test(test_pull_and_lossless),
        cmocka_unit_test(test_removed_and_added),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
