/*
 * Services that come and go, to a subscriber of libdexel that connects again. Whatever they say,
 * what the application is told makes sense: no tile before its stream, a reset before anything of
 * another connection, and the loss of one is never an error.
 *
 * Input: a byte of options, then messages with a short head (type, flags, epoch, u16 length), whose
 * framing is made right. Type GONE: the connection ends, and the next one is there.
 */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/timerfd.h>
#include <sys/un.h>
#include <unistd.h>

#include "client/session.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
const char *__asan_default_options(void);

/* As in fuzz_wire.c: a geometry that is too large cannot be had. */
const char *__asan_default_options(void)
{
    return "allocator_may_return_null=1:max_allocation_size_mb=64";
}

#define GONE 255

#define MUST(condition)                                                                            \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            fprintf(stderr, "fuzz_reconnect: not so: %s\n", #condition);                           \
            abort();                                                                               \
        }                                                                                          \
    } while (0)

/* What the application knows. */
struct application {
    bool has_stream, must_reset, is_gone;
    unsigned n_calls, n_gone, n_losses;
};

/* Stops the dispatch now and then. */
static int called(struct application *a)
{
    return ++a->n_calls % 8 == 7;
}

static int on_stream(void *user, const struct dexel_stream *s)
{
    struct application *a = user;

    MUST(!a->must_reset && s->height >= 2 && s->width >= 2);
    a->has_stream = true;
    return called(a);
}

static int on_reset(void *user, const char *reason)
{
    struct application *a = user;

    MUST(*reason || !a->must_reset);
    a->has_stream = a->must_reset = false;
    return called(a);
}

static int on_tile(void *user, const struct dexel_tile *t)
{
    struct application *a = user;

    MUST(a->has_stream && !a->must_reset);
    for (uint32_t i = 0; i < 3 * t->n_triangles; i++)
        MUST(t->index[i] < t->n_vertices);
    return called(a);
}

static int on_commit(void *user, const struct dexel_commit *c)
{
    struct application *a = user;

    (void)c;
    MUST(a->has_stream && !a->must_reset);
    return called(a);
}

static int on_state(void *user, enum dexel_state state, const char *reason)
{
    struct application *a = user;

    a->n_gone += state == DEXEL_GONE;
    MUST(state != DEXEL_GONE || strlen(reason) < DX_WIRE_TEXT + 200);
    return called(a);
}

/* ---- the services -----------------------------------------------------------------------------
 */

static char dir[] = "/tmp/dexeld-fuzz-XXXXXX", path[64];
static int listener;

static void clean(void)
{
    unlink(path);
    rmdir(dir);
}

static void start(void)
{
    struct sockaddr_un addr = {.sun_family = AF_UNIX};

    MUST(mkdtemp(dir));
    snprintf(path, sizeof(path), "%s/mesh", dir);
    strcpy(addr.sun_path, path);
    listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    MUST(bind(listener, (struct sockaddr *)&addr, sizeof(addr)) == 0);
    MUST(listen(listener, 16) == 0);
    atexit(clean);
}

struct talk {
    struct dexel *client;
    struct application app;
    int server; /* our end of the connection; -1: none */
    uint32_t seq;
};

/* False: the client has had enough. */
static bool dispatch(struct talk *t)
{
    int r = dexel_dispatch(t->client);

    MUST(r != -ECONNRESET);
    return r >= 0;
}

/* The client's timer, now: it connects, and we have the other end. */
static bool connect_next(struct talk *t)
{
    const struct itimerspec now = {.it_value.tv_nsec = 1};

    for (int k = 0; t->client->connection.fd < 0; k++) {
        MUST(k < 100);
        timerfd_settime(t->client->again.timer_fd, 0, &now, NULL);
        if (!dispatch(t))
            return false;
    }
    t->server = accept(listener, NULL, NULL);
    MUST(t->server >= 0);
    t->seq = 0;
    return true;
}

/* The connection is no more: the client has noticed it. */
static void count_loss(struct talk *t)
{
    close(t->server);
    t->server = -1;
    t->app.n_losses++;
    t->app.must_reset = t->app.must_reset || t->app.has_stream;
}

static bool hang_up(struct talk *t)
{
    shutdown(t->server, SHUT_RDWR);
    for (int k = 0; t->client->connection.fd >= 0; k++) { /* first what it has not handled yet */
        MUST(k < 1000);
        if (!dispatch(t))
            return false;
    }
    count_loss(t);
    return true;
}

static bool say(struct talk *t, const uint8_t *bytes, size_t len)
{
    uint8_t heard[4096];

    while (len && t->server >= 0) {
        ssize_t n = send(t->server, bytes, len, MSG_NOSIGNAL | MSG_DONTWAIT);

        bytes += n > 0 ? n : 0;
        len -= n > 0 ? (size_t)n : 0;
        if (!dispatch(t))
            return false;
        if (t->client->connection.fd < 0) /* at an ERROR that bids it to come again */
            count_loss(t);
        while (t->server >= 0 && recv(t->server, heard, sizeof(heard), MSG_DONTWAIT) > 0)
            ;
    }
    return true;
}

static bool say_message(struct talk *t, const uint8_t *head, size_t len)
{
    const struct dx_wire_header h = {.length = (uint32_t)len,
                                     .type = head[0],
                                     .flags = head[1],
                                     .stream = 1,
                                     .seq = t->seq++,
                                     .epoch = head[2]};
    uint8_t header[DX_WIRE_HEADER_LEN];

    dx_wire_put_header(header, &h);
    return say(t, header, sizeof(header)) && say(t, head + 5, len);
}

/* One step of the input; false: the client has had enough. */
static bool step(struct talk *t, const uint8_t *head, size_t len)
{
    if (t->client->asked.mode == DX_MODE_PULL && head[2] % 4 == 0)
        dexel_next(t->client);
    if (t->server < 0 && !connect_next(t))
        return false;
    if (head[0] == GONE)
        return hang_up(t);
    return say_message(t, head, len);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const struct dexel_callbacks callbacks = {
        .stream = on_stream,
        .reset = on_reset,
        .tile = on_tile,
        .commit = on_commit,
        .state = on_state,
    };
    struct dexel_options options = {.reconnect = 1, .want_attr = 1, .want_normals = 1};
    struct talk t = {.server = -1};

    if (size < 1)
        return 0;
    if (!*path)
        start();
    options.socket = path;
    options.encoding = (enum dexel_encoding)(data[0] % 3);
    options.mode = data[0] / 3 & 1 ? DEXEL_PULL : DEXEL_LIVE;
    MUST(dexel_open(&t.client, &options, &callbacks, &t.app) == 0);
    for (data++, size--; size >= 5;) {
        size_t len = dx_get_u16(data + 3);

        len = len < size - 5 ? len : size - 5;
        if (!step(&t, data, len))
            break;
        data += 5 + len;
        size -= 5 + len;
    }
    MUST(t.app.n_losses == 0 || t.app.n_gone > 0 || t.client->failed);
    dexel_close(t.client);
    if (t.server >= 0)
        close(t.server);
    return 0;
}
