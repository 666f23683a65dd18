/*
 * libdexel and the far end of its connection, for tests: a real socket whose other end is in the
 * hands of the test, in the same thread, and callbacks that note what they saw. Include after
 * cmocka.h.
 */
#ifndef DX_CLIENT_FIXTURE_H
#define DX_CLIENT_FIXTURE_H

#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "client/dexel.h"
#include "core/base/hash.h"
#include "tests/unit/tile_fixture.h"

/* What the callbacks saw. */
struct seen {
    int n_stream, n_reset, n_tile, n_raw, n_commit, n_state;
    int stop_at_tile; /* value to return from each tile */
    uint64_t hash;    /* of all meshes, in order */
    struct dexel_stream stream;
    struct dexel_commit commit;
    enum dexel_state state;
    char text[DX_WIRE_TEXT];
};

static inline uint64_t hash_mesh(uint64_t h, const struct dexel_tile *t)
{
    h = dx_hash_u64(h, (uint64_t)t->row << 32 | t->col);
    h = dx_hash(h, t->xyz, 12 * (size_t)t->n_vertices);
    h = dx_hash(h, t->index, 6 * (size_t)t->n_triangles);
    h = dx_hash(h, t->dexel, 4 * (size_t)t->n_vertices);
    if (t->attr)
        h = dx_hash(h, t->attr, 2 * (size_t)t->n_vertices);
    return t->normal ? dx_hash(h, t->normal, 12 * (size_t)t->n_vertices) : h;
}

static inline int on_stream(void *user, const struct dexel_stream *stream)
{
    struct seen *s = user;

    s->stream = *stream;
    s->n_stream++;
    return 0;
}

static inline int on_reset(void *user, const char *reason)
{
    struct seen *s = user;

    snprintf(s->text, sizeof(s->text), "%s", reason);
    s->n_reset++;
    return 0;
}

static inline int on_tile(void *user, const struct dexel_tile *tile)
{
    struct seen *s = user;

    s->hash = hash_mesh(s->hash, tile);
    s->n_tile++;
    return s->stop_at_tile;
}

static inline int on_raw_tile(void *user, const uint8_t *chunk, size_t len)
{
    struct seen *s = user;

    s->hash = dx_hash(s->hash, chunk, len);
    s->n_raw++;
    return 0;
}

static inline int on_commit(void *user, const struct dexel_commit *commit)
{
    struct seen *s = user;

    s->commit = *commit;
    s->n_commit++;
    return 0;
}

static inline int on_state(void *user, enum dexel_state state, const char *reason)
{
    struct seen *s = user;

    s->state = state;
    snprintf(s->text, sizeof(s->text), "%s", reason);
    s->n_state++;
    return 0;
}

static const struct dexel_callbacks callbacks = {
    .stream = on_stream,
    .reset = on_reset,
    .tile = on_tile,
    .commit = on_commit,
    .state = on_state,
};

/* A client and the server's end of its connection. */
struct session {
    char dir[32], path[64];
    int server;
    struct dexel *client;
    struct seen seen;
    struct script script;
};

static inline void open_session(struct session *s, struct dexel_options options,
                                const struct dexel_callbacks *cb)
{
    struct sockaddr_un addr = {.sun_family = AF_UNIX};
    int listener, room = 4 << 20;

    memset(s, 0, sizeof(*s));
    strcpy(s->dir, "/tmp/dexel-test-XXXXXX");
    assert_non_null(mkdtemp(s->dir));
    snprintf(s->path, sizeof(s->path), "%s/s", s->dir);
    memcpy(addr.sun_path, s->path, strlen(s->path) + 1);
    listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_true(listener >= 0);
    assert_int_equal(bind(listener, (struct sockaddr *)&addr, sizeof(addr)), 0);
    assert_int_equal(listen(listener, 1), 0);
    options.socket = s->path;
    assert_int_equal(dexel_open(&s->client, &options, cb, &s->seen), 0);
    s->server = accept4(listener, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
    assert_true(s->server >= 0);
    setsockopt(s->server, SOL_SOCKET, SO_SNDBUF, &room, sizeof(room));
    close(listener);
}

static inline void close_session(struct session *s)
{
    dexel_close(s->client);
    if (s->server >= 0)
        close(s->server);
    unlink(s->path);
    rmdir(s->dir);
    free(s->script.bytes);
}

static inline void hang_up(struct session *s)
{
    close(s->server);
    s->server = -1;
}

/* Sends the script, dispatching in between so that a full socket is no obstacle; the last result.
 */
static inline int play(struct session *s, size_t step)
{
    int r = 0;

    for (size_t at = 0; at < s->script.len && r == 0;) {
        size_t n = s->script.len - at < step ? s->script.len - at : step;
        ssize_t sent = send(s->server, s->script.bytes + at, n, MSG_NOSIGNAL);

        assert_true(sent > 0 || errno == EAGAIN);
        at += sent > 0 ? (size_t)sent : 0;
        r = dexel_dispatch(s->client);
    }
    s->script.len = 0;
    for (struct pollfd p = {.fd = dexel_fd(s->client), .events = POLLIN};
         r == 0 && poll(&p, 1, 0) == 1 && s->server >= 0;)
        r = dexel_dispatch(s->client);
    return r;
}

/* What a q16 server says up to the first tile. */
static inline void start(struct script *s, const struct dx_geometry *g)
{
    script_welcome(s);
    script_subscribed(s, g, DX_ENCODING_Q16, 0);
    script_message(s, DX_MSG_SNAPSHOT_BEGIN, 0, 1, NULL, 0);
}

static inline void small_tile(struct script *s, const struct dx_geometry *g, enum dx_encoding e,
                              uint64_t epoch, uint8_t attr_bytes)
{
    struct dx_tiling t;
    struct dx_tile tile;

    dx_tiling_init(&t, 3, 3, false);
    fixture_small_tile(&tile);
    tile.attr_bytes = attr_bytes;
    script_tile(s, e, epoch, &tile, &t, g);
}

#endif
