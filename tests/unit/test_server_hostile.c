/* Clients that break the protocol, and limits: each gets its answer, and nobody else notices. */
#include "tests/unit/control_ask.h"

#include <sys/resource.h>
#include <sys/stat.h>

#include "core/base/rng.h"
#include "daemon/outbox.h"

#define MS 1000000u

static void test_refusals(void **state)
{
    const struct dx_msg_subscribe other = {.stream = "other"},
                                  lossless = {.mode = DX_MODE_LOSSLESS},
                                  q16 = {.encoding = DX_ENCODING_Q16};
    struct fixture *fx = fixture_start(NULL);
    struct client *c;

    (void)state;
    c = client_start(fx, &other);
    client_until(c, DX_MSG_WELCOME); /* the greeting was fine */
    client_expect_error(c, DX_WIRE_E_NO_STREAM);
    client_expect_error(client_start(fx, &lossless), DX_WIRE_E_MODE);
    c = client_connect(fx);
    client_hello(c, DX_WIRE_MAJOR + 1, 3);
    client_expect_error(c, DX_WIRE_E_VERSION);
    c = client_connect(fx);
    client_hello(c, DX_WIRE_MAJOR, 0x80);
    client_expect_error(c, DX_WIRE_E_ENCODING);
    c = client_connect(fx);
    client_hello(c, DX_WIRE_MAJOR, 1);
    client_subscribe(c, &q16); /* not what HELLO said */
    client_expect_error(c, DX_WIRE_E_ENCODING);
    c = client_connect(fx);
    client_subscribe(c, &q16); /* no HELLO */
    client_expect_error(c, DX_WIRE_E_PROTOCOL);
    c = client_start(fx, NULL);
    client_send(c, DX_MSG_NEXT, NULL, 0); /* not in pull mode */
    client_expect_error(c, DX_WIRE_E_PROTOCOL);
    fixture_stop(fx);
}

/* A client of before 1.0 is told what to do; one of a later minor is served in ours. */
static void test_versions(void **state)
{
    struct fixture *fx = fixture_start(NULL);
    struct client *c = client_connect(fx);

    (void)state;
    client_hello_of(c, 0, 3, 1);
    client_until_closed(c);
    assert_int_equal(c->error.code, DX_WIRE_E_VERSION);
    assert_string_equal(c->error.text,
                        "found protocol 0.3, expected 1.x: take a client of that version");
    client_close(c);
    c = client_connect(fx);
    client_hello_of(c, DX_WIRE_MAJOR, DX_WIRE_MINOR + 5, 1);
    client_subscribe(c, &(struct dx_msg_subscribe){0});
    client_until_frame(c, 3);
    assert_int_equal(c->greeting.major, DX_WIRE_MAJOR);
    assert_int_equal(c->greeting.minor, DX_WIRE_MINOR);
    assert_int_equal(c->greeting.features, 0);
    client_close(c);
    fixture_stop(fx);
}

/* Levels of detail that there are not, in words; and one more than there is room for. */
static void test_levels_refused(void **state)
{
    struct fixture *fx = fixture_start(NULL);
    struct client *held[DX_LOD_SLOTS], *c;

    (void)state;
    client_expect_error(client_start(fx, &(struct dx_msg_subscribe){.lod = {.bound = 65535}}),
                        DX_WIRE_E_PROTOCOL);
    c = client_start(fx, &(struct dx_msg_subscribe){.lod = {.stride = 5}});
    client_until(c, DX_MSG_ERROR);
    assert_non_null(strstr(c->error.text, "stride is 2, 4"));
    client_close(c);
    client_expect_error(client_start(fx, &(struct dx_msg_subscribe){.encoding = DX_ENCODING_DELTA,
                                                                    .lod = {.bound = 16}}),
                        DX_WIRE_E_ENCODING);
    for (uint16_t k = 0; k < DX_LOD_SLOTS; k++) {
        held[k] = client_start(fx, &(struct dx_msg_subscribe){.lod = {.bound = (uint16_t)(k + 1)}});
        client_until_frame(held[k], 3);
    }
    c = client_start(fx, &(struct dx_msg_subscribe){.lod = {.stride = 8}});
    client_until(c, DX_MSG_ERROR);
    assert_int_equal(c->error.code, DX_WIRE_E_LIMIT);
    assert_non_null(strstr(c->error.text, "bound 0.0625 stride 0"));
    client_close(c);
    /* who comes to one of them is welcome; so is a new one where one has left */
    c = client_start(fx, &(struct dx_msg_subscribe){.lod = {.bound = 2}});
    client_until_frame(c, 3);
    assert_int_equal(c->told.lod.bound, 2);
    client_close(c);
    client_send(held[2], DX_MSG_NEXT, NULL, 0); /* ends it, and says when it has */
    client_expect_error(held[2], DX_WIRE_E_PROTOCOL);
    c = client_start(fx, &(struct dx_msg_subscribe){.lod = {.stride = 8}});
    client_until_frame(c, 3);
    assert_int_equal(c->told.lod.stride, 8);
    client_close(c);
    for (int k = 0; k < DX_LOD_SLOTS; k++)
        if (k != 2)
            client_close(held[k]);
    fixture_stop(fx);
}

static void test_absurd_lengths(void **state)
{
    const uint32_t lengths[] = {DX_WIRE_MAX_CLIENT_BODY + 1, 0x7fffffff, 0xffffffff, 0xffffffe8};
    struct fixture *fx = fixture_start(NULL);

    (void)state;
    for (int k = 0; k < 4; k++) {
        struct dx_wire_header h = {.length = lengths[k], .type = DX_MSG_HELLO};
        struct client *c = client_connect(fx);
        uint8_t head[DX_WIRE_HEADER_LEN];

        dx_wire_put_header(head, &h);
        assert_int_equal(send(c->fd, head, sizeof(head), MSG_NOSIGNAL), sizeof(head));
        client_expect_error(c, DX_WIRE_E_PROTOCOL);
    }
    fixture_stop(fx);
}

static void test_unknown_messages(void **state)
{
    struct dx_wire_header h = {.length = 100, .type = 999, .flags = DX_WIRE_SKIPPABLE};
    struct fixture *fx = fixture_start(NULL);
    struct client *c = client_start(fx, NULL);
    uint8_t bytes[DX_WIRE_HEADER_LEN + 100] = {0};

    (void)state;
    client_until_frame(c, 3);
    dx_wire_put_header(bytes, &h);
    assert_int_equal(send(c->fd, bytes, sizeof(bytes), MSG_NOSIGNAL), sizeof(bytes));
    fixture_frames(fx, 4);
    client_until_frame(c, 4); /* skipped */
    h.flags = 0;
    dx_wire_put_header(bytes, &h);
    assert_int_equal(send(c->fd, bytes, sizeof(bytes), MSG_NOSIGNAL), sizeof(bytes));
    client_expect_error(c, DX_WIRE_E_PROTOCOL);
    fixture_stop(fx);
}

static void test_half_a_hello(void **state)
{
    struct fixture *fx = fixture_start(&(struct fixture_options){.server = {.hello_ns = 100 * MS}});
    struct client *good = client_start(fx, NULL), *half = client_connect(fx),
                  *mute = client_connect(fx);

    (void)state;
    client_until_frame(good, 3);
    assert_int_equal(send(half->fd, "DEXL", 4, MSG_NOSIGNAL), 4);
    client_expect_error(half, DX_WIRE_E_PROTOCOL); /* at its deadline */
    client_expect_error(mute, DX_WIRE_E_PROTOCOL);
    fixture_frames(fx, 4);
    client_until_frame(good, 4);
    client_close(good);
    fixture_stop(fx);
}

/* A HELLO in pieces is a HELLO. */
static void test_hello_byte_by_byte(void **state)
{
    struct fixture *fx = fixture_start(NULL);
    struct client *c = client_connect(fx);
    uint8_t bytes[256];
    struct dx_wire_header h = {.type = DX_MSG_HELLO};
    struct dx_msg_hello m = {DX_WIRE_MAJOR, DX_WIRE_MINOR, 0, 1};
    struct dx_writer w = dx_writer_init(bytes + DX_WIRE_HEADER_LEN, 200);

    (void)state;
    dx_msg_hello_put(&w, &m);
    h.length = (uint32_t)(w.p - bytes - DX_WIRE_HEADER_LEN);
    dx_wire_put_header(bytes, &h);
    for (uint8_t *p = bytes; p < w.p; p++)
        assert_int_equal(send(c->fd, p, 1, MSG_NOSIGNAL), 1);
    client_subscribe(c, &(struct dx_msg_subscribe){0});
    client_until_frame(c, 3);
    client_close(c);
    fixture_stop(fx);
}

static void test_random_bytes(void **state)
{
    struct fixture *fx = fixture_start(NULL);
    struct client *good = client_start(fx, NULL);
    struct dx_rng rng = dx_rng_init(1, 0);
    uint64_t f = 3;

    (void)state;
    client_until_frame(good, 3);
    for (int k = 0; k < 300; k++) {
        struct client *c = k % 3 ? client_start(fx, NULL) : client_connect(fx);
        uint8_t bytes[4096];
        size_t len = 1 + dx_rng_below(&rng, sizeof(bytes));

        for (size_t i = 0; i < len; i++)
            bytes[i] = (uint8_t)dx_rng_u64(&rng);
        if (k % 2) /* a length that passes, so that the type is looked at */
            dx_put_u32(bytes, dx_rng_below(&rng, 64));
        if (send(c->fd, bytes, len, MSG_NOSIGNAL) < 0)
            assert_true(errno == EPIPE || errno == ECONNRESET);
        client_close(c);
        if (k % 10 == 0) {
            fixture_frames(fx, ++f);
            client_until_frame(good, f);
        }
    }
    assert_int_equal(good->n_resets, 0);
    client_close(good);
    fixture_stop(fx);
}

static void test_a_thousand_connects(void **state)
{
    struct fixture *fx = fixture_start(NULL);
    struct client *good = client_start(fx, NULL);
    uint64_t f = 3;

    (void)state;
    client_until_frame(good, 3);
    for (int k = 0; k < 1000; k++) {
        if (k % 2)
            client_close(client_connect(fx));
        else
            client_close(client_start(fx, NULL));
        if (k % 50 == 0) {
            fixture_frames(fx, ++f);
            client_until_frame(good, f);
        }
    }
    assert_int_equal(good->n_resets, 0);
    client_close(good);
    fixture_stop(fx);
}

/* Refuses one more than the limits allow, when it connects or when it subscribes, in these words;
 * whoever is there notices nothing, and one who goes makes room. */
static void expect_limit(const struct dx_server_limits *limits, bool at_once, const char *text)
{
    struct fixture *fx = fixture_start(&(struct fixture_options){.server = {.limits = *limits}});
    struct client *a = client_start(fx, NULL), *b = client_start(fx, NULL), *c;

    client_until_frame(a, 3);
    client_until_frame(b, 3);
    c = at_once ? client_connect(fx) : client_start(fx, NULL);
    client_until_closed(c);
    assert_int_equal(c->error.code, DX_WIRE_E_LIMIT);
    assert_string_equal(c->error.text, text);
    client_close(c);
    fixture_frames(fx, 4);
    client_until_frame(a, 4);
    client_until_frame(b, 4);
    client_send(a, DX_MSG_NEXT, NULL, 0); /* ends it, and says when it has */
    client_expect_error(a, DX_WIRE_E_PROTOCOL);
    c = client_start(fx, NULL);
    client_until_frame(c, 4);
    client_close(c);
    client_close(b);
    fixture_stop(fx);
}

static void test_limit(void **state)
{
    char text[100];

    (void)state;
    expect_limit(&(struct dx_server_limits){.max_clients = 2}, true,
                 "too many subscribers: 2 (max_clients)");
    snprintf(text, sizeof(text), "too many subscribers of user %u: 2 (max_clients_per_uid)",
             (unsigned)getuid());
    expect_limit(&(struct dx_server_limits){.max_clients_per_uid = 2}, true, text);
    /* a subscriber of the fixture's small grid holds little more than its buffer of 256 KiB */
    expect_limit(&(struct dx_server_limits){.client_memory = 3 * DX_OUTBOX_OWN}, false,
                 "too much memory for subscribers: 1 MiB (client_memory_mib)");
}

/* Out of descriptors the server looks away from the socket for a moment; when some are free, it
 * goes on. */
static void test_out_of_descriptors(void **state)
{
    struct fixture *fx = fixture_start(NULL);
    struct client *good = client_start(fx, NULL), *late;
    struct rlimit old, now;
    int next;

    (void)state;
    client_until_frame(good, 3);
    late = calloc(1, sizeof(*late));
    late->fx = fx;
    next = dup(0);
    close(next);
    getrlimit(RLIMIT_NOFILE, &old);
    now = old;
    now.rlim_cur = (rlim_t)next + 1; /* one more: the client's own */
    setrlimit(RLIMIT_NOFILE, &now);
    late->fd = client_socket(fx->mesh, 0);
    client_hello(late, DX_WIRE_MAJOR, 1);
    client_subscribe(late, &(struct dx_msg_subscribe){0});
    for (uint64_t f = 4; f < 10; f++) {
        fixture_frames(fx, f);
        client_until_frame(good, f);
    }
    setrlimit(RLIMIT_NOFILE, &old);
    client_until_frame(late, 9);
    client_close(late);
    client_close(good);
    fixture_stop(fx);
}

/* The last descriptors are not for subscribers: whoever comes for one is told, and an operator is
 * answered. */
static void test_kept_descriptors(void **state)
{
    enum { MAX = 64, KEPT = MAX / 8 };
    struct fixture *fx = fixture_start(NULL);
    struct client *good = client_start(fx, NULL), *late;
    int filler[MAX], n = 0, fd;
    struct rlimit old, now;

    (void)state;
    client_until_frame(good, 3);
    getrlimit(RLIMIT_NOFILE, &old);
    now = old;
    now.rlim_cur = MAX;
    setrlimit(RLIMIT_NOFILE, &now);
    do { /* up to the client's own, behind which the service's is the first that is kept */
        filler[n] = dup(0);
        assert_true(filler[n] >= 0);
    } while (filler[n++] < MAX - KEPT - 2);
    late = client_connect(fx);
    client_until_closed(late);
    assert_int_equal(late->error.code, DX_WIRE_E_LIMIT);
    assert_string_equal(late->error.text,
                        "too few descriptors: the last of 64 are for operators (LimitNOFILE=)");
    fd = client_socket(fx->control, 0);
    json_decref(control_ask(fd, "{\"request\":\"status\"}\n"));
    close(fd);
    while (n--)
        close(filler[n]);
    setrlimit(RLIMIT_NOFILE, &old);
    fixture_frames(fx, 4);
    client_until_frame(good, 4);
    client_close(late);
    client_close(good);
    fixture_stop(fx);
}

/* ---- the paths
 * ----------------------------------------------------------------------------------- */

static void test_paths(void **state)
{
    struct fixture *fx = fixture_start(NULL);
    struct dx_server_options o = {.mesh_path = fx->mesh};
    struct dx_server *second = NULL;
    struct sockaddr_un addr = {.sun_family = AF_UNIX};
    struct dx_err err;
    struct stat st;
    char path[100];
    int fd;

    (void)state;
    assert_int_equal(stat(fx->mesh, &st), 0);
    assert_int_equal(st.st_mode & 0777, 0660);
    assert_int_equal(dx_server_new(&second, &o, &err), -EADDRINUSE);
    assert_non_null(strstr(err.text, fx->mesh));
    client_close(client_start(fx, NULL)); /* the first one is still there */

    snprintf(path, sizeof(path), "%s/stale", fx->dir); /* a socket nobody listens on */
    snprintf(addr.sun_path, sizeof(addr.sun_path), "%s", path);
    fd = socket(AF_UNIX, SOCK_STREAM, 0);
    assert_int_equal(bind(fd, (struct sockaddr *)&addr, sizeof(addr)), 0);
    close(fd);
    o.mesh_path = path;
    assert_int_equal(dx_server_new(&second, &o, &err), 0);
    dx_server_free(second);
    assert_int_equal(access(path, F_OK), -1);

    fclose(fopen(path, "w")); /* somebody's file */
    assert_int_equal(dx_server_new(&second, &o, &err), -EEXIST);
    assert_int_equal(unlink(path), 0);
    fixture_stop(fx);
}

/* ---- the control socket
 * -------------------------------------------------------------------------- */

static json_int_t get_int(const json_t *o, const char *key)
{
    assert_true(json_is_integer(json_object_get(o, key)));
    return json_integer_value(json_object_get(o, key));
}

/* The fixture's epochs spend 1, 2, 4 and 8 ms in their stages; a quantile is told to an eighth. */
static void check_stages(const json_t *stream)
{
    static const char *const names[] = {"decode", "wait", "mesh", "encode"};
    const json_t *stages = json_object_get(json_object_get(stream, "latency_ms"), "stages");

    for (int k = 0; k < 4; k++) {
        const json_t *stage = json_object_get(stages, names[k]);
        double ms = 1 << k;

        assert_true(json_real_value(json_object_get(stage, "p50")) > 0.87 * ms);
        assert_true(json_real_value(json_object_get(stage, "p99")) <= ms);
    }
}

static void test_status(void **state)
{
    struct fixture *fx = fixture_start(NULL);
    struct client *c = client_start(fx, NULL);
    int fd = client_socket(fx->control, 0);
    json_t *reply, *stream, *client;

    (void)state;
    client_until_frame(c, 3);
    fixture_frames(fx, 4); /* after the snapshot: latencies are of what comes live */
    client_until_frame(c, 4);
    reply = control_ask(fd, "{\"request\":\"status\"}\n");
    stream = json_array_get(json_object_get(reply, "streams"), 0);
    client = json_array_get(json_object_get(reply, "clients"), 0);
    assert_string_equal(json_string_value(json_object_get(stream, "name")), "test");
    assert_string_equal(json_string_value(json_object_get(stream, "geometry")), "pinhole");
    assert_int_equal(get_int(stream, "width"), 180);
    assert_true(get_int(stream, "tiles_sent") > 0);
    check_stages(stream);
    assert_int_equal(get_int(client, "pid"), getpid());
    assert_int_equal(get_int(client, "epochs"), c->n_commits);
    assert_int_equal(get_int(client, "resets"), 0);
    assert_true(get_int(reply, "rss_bytes") > 0);
    json_decref(reply);
    close(fd);
    client_close(c);
    fixture_stop(fx);
}

static void test_control_errors(void **state)
{
    static const char *const lines[] = {"\n", "{\n", "[]\n", "{\"request\":7}\n",
                                        "{\"request\":\"dance\"}\n"};
    struct fixture *fx = fixture_start(NULL);
    int fd = client_socket(fx->control, 0);
    char text[2000];

    (void)state;
    for (int k = 0; k < 5; k++) {
        json_t *reply = control_ask(fd, lines[k]);

        assert_non_null(json_string_value(json_object_get(reply, "error")));
        json_decref(reply);
    }
    memset(text, 'x', sizeof(text)); /* a line without an end */
    send(fd, text, sizeof(text), MSG_NOSIGNAL);
    control_expect_error(control_hear(fd), "too long a request");
    assert_true(recv(fd, text, sizeof(text), 0) <= 0);
    close(fd);
    for (int k = 0; k < 40; k++) { /* idle ones give way */
        int other = client_socket(fx->control, 0);

        if (k == 39) {
            json_t *reply = control_ask(other, "{\"request\":\"quit\"}\n");

            json_decref(reply);
            fixture_join_server(fx);
        }
        if (k % 2)
            close(other);
    }
    fixture_stop(fx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_versions),
        cmocka_unit_test(test_levels_refused),
        cmocka_unit_test(test_absurd_lengths),
        cmocka_unit_test(test_unknown_messages),
        cmocka_unit_test(test_half_a_hello),
        cmocka_unit_test(test_hello_byte_by_byte),
        cmocka_unit_test(test_random_bytes),
        cmocka_unit_test(test_a_thousand_connects),
        cmocka_unit_test(test_limit),
        cmocka_unit_test(test_out_of_descriptors),
        cmocka_unit_test(test_kept_descriptors),
        cmocka_unit_test(test_paths),
        cmocka_unit_test(test_status),
        cmocka_unit_test(test_control_errors),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
