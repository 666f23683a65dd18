/*
 * A server in a thread on a socket of its own, a scripted mesher in another, and raw clients that
 * hold the server to the protocol: order of messages, numbering, and after each COMMIT exactly the
 * mesh of its frame.
 */
#ifndef SERVER_FIXTURE_H
#define SERVER_FIXTURE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "core/base/hash.h"
#include "core/wire/wire.h"
#include "daemon/feed_priv.h"
#include "daemon/log.h"
#include "daemon/server.h"

#define MAX_TILES 128

struct fixture {
    char dir[64], mesh[96], control[108];
    struct dx_server *server;
    struct dx_feed *feed;
    struct dx_counters counters;
    pthread_t server_thread, mesher_thread;
    bool server_runs;
    _Atomic uint32_t n_subscribers;

    /* the mesher; `target`, `stop`, `next_*` are the test's, the rest its own */
    sem_t wake;
    _Atomic uint64_t target;
    _Atomic bool stop;
    _Atomic uint64_t done_frame; /* published */
    _Atomic uint32_t grid;       /* number of the geometry wanted */
    _Atomic int state;           /* to be told after the target, -1: none */
    bool lossless;
    uint32_t body_len; /* longest */
    uint8_t attr_bytes;
};

struct fixture_options {
    struct dx_server_options server;
    bool lossless;
    uint32_t body_len; /* 0: up to 300 bytes */
    uint32_t n_blocks; /* 0: plenty */
    uint32_t grid;
    uint8_t attr_bytes;
    bool no_mesh; /* until target moves there is no geometry */
};

/* Geometries of 2x3, 3x4 and 10x11 tiles, odd sizes; from 100 on with 32-bit ranges, from 200 on a
 * table. */
static const struct fixture_grid {
    uint32_t height, width, rows, cols;
} fixture_grids[] = {{100, 180, 2, 3}, {190, 250, 3, 4}, {640, 700, 10, 11}};

static inline const struct fixture_grid *fixture_grid(uint32_t grid)
{
    return &fixture_grids[grid % 100];
}

static inline struct dx_geometry *fixture_geometry(uint32_t grid)
{
    const struct fixture_grid *size = fixture_grid(grid);
    struct dx_geometry *g;

    assert_int_equal(dx_geometry_new(&g, grid >= 200 ? DX_MODEL_TABLE : DX_MODEL_PINHOLE,
                                     size->height, size->width),
                     0);
    g->range_bytes = grid >= 100 && grid < 200 ? 4 : 2;
    g->unit_m = 0.001f;
    for (size_t k = 0; k < g->n_table; k++)
        g->table[k] = (float)k * 0.25f;
    return g;
}

static inline uint32_t fixture_n_tiles(uint32_t grid)
{
    return fixture_grid(grid)->rows * fixture_grid(grid)->cols;
}

/* What tile `t` of a frame holds: the last frame that changed it, times 100, and itself; some are
 * empty. */
static inline uint64_t fixture_version(uint64_t frame, uint32_t t)
{
    uint64_t last = frame - frame % (1 + t % 3);

    return last == 0 || (last + t) % 5 == 0 ? 0 : 100 * last + t;
}

/* TILE body of a version: a chunk's header, the version, and bytes that follow from it. */
static inline size_t fixture_body(uint8_t *body, uint64_t version, unsigned encoding, uint32_t cols,
                                  uint32_t tile, uint32_t max_len, uint8_t attr_bytes)
{
    uint16_t n = (uint16_t)(version ? 1 + dx_hash_u64(9, version) % max_len : 0);

    memset(body, 0, DX_CHUNK_HEADER_LEN);
    dx_put_u16(body, (uint16_t)(tile / cols));
    dx_put_u16(body + 2, (uint16_t)(tile % cols));
    body[4] = (uint8_t)encoding;
    if (!version)
        return DX_CHUNK_HEADER_LEN;
    body[5] = attr_bytes;
    dx_put_u16(body + 6, n);
    dx_put_u16(body + 8, 1);
    body += DX_CHUNK_HEADER_LEN;
    dx_put_u64(body, version);
    for (uint32_t k = 0; k < n; k++)
        body[8 + k] = (uint8_t)(version * 31 + k + encoding);
    memset(body + 8 + n, 0xaa, (size_t)attr_bytes * n);
    return DX_CHUNK_HEADER_LEN + 8 + n + (size_t)attr_bytes * n;
}

/* ---- the mesher
 * ---------------------------------------------------------------------------------- */

struct mesher {
    struct fixture *fx;
    uint64_t epoch, frame;
    uint32_t grid;
    bool announced;
    uint32_t served[DX_N_ENCODINGS];
};

static inline bool mesher_add(struct mesher *m, uint64_t frame, const uint32_t *generation)
{
    static uint8_t body[DX_WIRE_MAX_BODY];
    struct fixture *fx = m->fx;
    uint32_t n_tiles = fixture_n_tiles(m->grid);

    dx_feed_begin(fx->feed, m->epoch + 1, generation);
    for (uint32_t k = 0; k < DX_N_ENCODINGS * n_tiles; k++) {
        uint32_t e = k / n_tiles, t = k % n_tiles;
        uint64_t version = fixture_version(frame, t);

        if (!generation[e] ||
            (generation[e] == m->served[e] && version == fixture_version(m->frame, t)))
            continue;
        if (!dx_feed_add(fx->feed, t, (enum dx_encoding)e, body,
                         fixture_body(body, version, e, fixture_grid(m->grid)->cols, t,
                                      fx->body_len, fx->attr_bytes)))
            return false;
    }
    return true;
}

/* False: nothing to do, or not now. */
static inline bool mesher_publish(struct mesher *m)
{
    struct fixture *fx = m->fx;
    uint32_t generation[DX_N_ENCODINGS];
    uint64_t frame = m->frame, target = atomic_load(&fx->target);
    bool unserved = false;

    dx_feed_wanted(fx->feed, generation);
    for (int e = 0; e < DX_N_ENCODINGS; e++)
        unserved |= generation[e] && generation[e] != m->served[e];
    if (frame < target && (!fx->lossless || dx_feed_lossless_epoch(fx->feed) >= m->epoch))
        frame++;
    else if (!unserved || frame == 0)
        return false;
    if (!mesher_add(m, frame, generation)) {
        dx_feed_abort(fx->feed);
        dx_count(&fx->counters.n_short_of_chunks, 1);
        return false;
    }
    dx_feed_commit(fx->feed, &(struct dx_msg_commit){.frame = frame, .host_ns = 1});
    memcpy(m->served, generation, sizeof(m->served));
    m->epoch++;
    m->frame = frame;
    dx_count(&fx->counters.n_frames, 1);
    return true;
}

static inline void mesher_announce(struct mesher *m)
{
    struct dx_geometry *g;
    struct dx_terrain_params params;

    m->grid = atomic_load(&m->fx->grid);
    m->announced = true;
    g = fixture_geometry(m->grid);
    dx_terrain_params_default(&params);
    dx_feed_reset(m->fx->feed, g, &params, m->fx->attr_bytes, "another geometry");
    dx_geometry_unref(g);
    memset(m->served, 0, sizeof(m->served));
    m->frame = m->frame ? m->frame - 1 : 0; /* the same frame again, on the new grid */
}

static inline void *mesher_main(void *fixture)
{
    struct fixture *fx = fixture;
    struct mesher m = {.fx = fx};
    int told = -1;

    while (!atomic_load(&fx->stop)) {
        int state = atomic_load(&fx->state);

        if (atomic_load(&fx->target) && (!m.announced || (m.grid != atomic_load(&fx->grid) &&
                                                          m.frame == atomic_load(&fx->target))))
            mesher_announce(&m);
        while (m.announced && mesher_publish(&m))
            ;
        if (state >= 0 && state != told && m.frame == atomic_load(&fx->target)) {
            dx_feed_state(fx->feed, (enum dx_stream_state)state, "as the test says");
            told = state;
        }
        atomic_store(&fx->done_frame, m.frame);
        sem_wait(&fx->wake);
    }
    return NULL;
}

static inline void fixture_kick(void *fx)
{
    sem_post(&((struct fixture *)fx)->wake);
}

/* The mesher publishes up to frame n, each as an epoch of its own. */
static inline void fixture_frames(struct fixture *fx, uint64_t n)
{
    atomic_store(&fx->target, n);
    fixture_kick(fx);
}

static inline void fixture_state(struct fixture *fx, enum dx_stream_state state)
{
    atomic_store(&fx->state, state);
    fixture_kick(fx);
}

/* ---- start and end
 * ------------------------------------------------------------------------------- */

static inline void fixture_count(void *fx, uint32_t n)
{
    atomic_store(&((struct fixture *)fx)->n_subscribers, n);
}

static inline void *server_main(void *fixture)
{
    struct fixture *fx = fixture;
    int r = dx_server_run(fx->server);

    return (void *)(intptr_t)r;
}

static inline struct fixture *fixture_start(const struct fixture_options *options)
{
    static const struct fixture_options defaults;
    struct fixture *fx = calloc(1, sizeof(*fx));
    struct dx_server_options o;
    struct dx_err err;
    uint32_t n_blocks;

    options = options ? options : &defaults;
    fx->body_len = options->body_len ? options->body_len : 300;
    fx->lossless = options->lossless;
    fx->attr_bytes = options->attr_bytes;
    atomic_store(&fx->state, -1);
    atomic_store(&fx->grid, options->grid);
    dx_log_set_level(LOG_ERR);
    strcpy(fx->dir, "/tmp/dexeld-test-XXXXXX");
    assert_non_null(mkdtemp(fx->dir));
    snprintf(fx->mesh, sizeof(fx->mesh), "%s/mesh.sock", fx->dir);
    snprintf(fx->control, sizeof(fx->control), "%s/control.sock", fx->dir);
    o = options->server;
    o.mesh_path = fx->mesh;
    o.control_path = fx->control;
    sem_init(&fx->wake, 0, 0);
    if (dx_server_new(&fx->server, &o, &err) < 0)
        fail_msg("%s", err.text);
    n_blocks = options->n_blocks ? options->n_blocks : 16384;
    assert_int_equal(
        dx_feed_new_sized(&fx->feed, MAX_TILES, n_blocks, 2048, 64, -1, fixture_kick, fx), 0);
    assert_int_equal(
        dx_server_add_stream(fx->server,
                             &(struct dx_server_stream_options){.name = "test",
                                                                .feed = fx->feed,
                                                                .counters = &fx->counters,
                                                                .lossless = options->lossless,
                                                                .subscribers = fixture_count,
                                                                .ctx = fx}),
        0);
    assert_int_equal(pthread_create(&fx->server_thread, NULL, server_main, fx), 0);
    fx->server_runs = true;
    assert_int_equal(pthread_create(&fx->mesher_thread, NULL, mesher_main, fx), 0);
    if (!options->no_mesh)
        fixture_frames(fx, 3);
    while (!options->no_mesh && atomic_load(&fx->done_frame) < 3)
        sched_yield();
    return fx;
}

static inline void fixture_join_server(struct fixture *fx)
{
    void *r;

    pthread_join(fx->server_thread, &r);
    fx->server_runs = false;
    assert_int_equal((intptr_t)r, 0);
}

static inline void fixture_stop(struct fixture *fx)
{
    atomic_store(&fx->stop, true);
    fixture_kick(fx);
    pthread_join(fx->mesher_thread, NULL);
    if (fx->server_runs) {
        dx_server_stop(fx->server);
        fixture_join_server(fx);
    }
    dx_server_free(fx->server);
    assert_int_equal(access(fx->mesh, F_OK), -1); /* unlinked */
    dx_feed_free(fx->feed);
    sem_destroy(&fx->wake);
    assert_int_equal(rmdir(fx->dir), 0);
    free(fx);
}

/* ---- a raw client
 * -------------------------------------------------------------------------------- */

struct client {
    struct fixture *fx;
    int fd;
    uint32_t seq;
    struct dx_msg_subscribe asked;
    bool welcome, subscribed, in_snapshot, had_snapshot;
    struct dx_msg_subscribed told;
    uint32_t geometry_len; /* bytes seen */
    uint64_t held[MAX_TILES];
    uint32_t n_tiles; /* of the open batch */
    uint64_t batch_epoch;
    struct dx_msg_commit commit;
    uint64_t epoch; /* of the last COMMIT */
    uint32_t n_commits, n_resets;
    struct dx_msg_error error;
    struct dx_msg_stream_state state;
    struct dx_msg_reset reset;
    bool slow_reader; /* a byte at a time */
    uint8_t body[DX_WIRE_MAX_BODY];
};

static inline int client_socket(const char *path, int rcvbuf)
{
    struct sockaddr_un addr = {.sun_family = AF_UNIX};
    struct timeval t = {.tv_sec = 20};
    int fd = socket(AF_UNIX, SOCK_STREAM, 0);

    snprintf(addr.sun_path, sizeof(addr.sun_path), "%s", path);
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &t, sizeof(t));
    if (rcvbuf)
        setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &rcvbuf, sizeof(rcvbuf));
    assert_int_equal(connect(fd, (struct sockaddr *)&addr, sizeof(addr)), 0);
    return fd;
}

static inline struct client *client_connect(struct fixture *fx)
{
    struct client *c = calloc(1, sizeof(*c));

    c->fx = fx;
    c->fd = client_socket(fx->mesh, 0);
    return c;
}

static inline void client_close(struct client *c)
{
    close(c->fd);
    free(c);
}

static inline void client_send(struct client *c, uint16_t type, const uint8_t *body, size_t len)
{
    uint8_t bytes[2048];
    struct dx_wire_header h = {.length = (uint32_t)len, .type = type};

    dx_wire_put_header(bytes, &h);
    if (len)
        memcpy(bytes + DX_WIRE_HEADER_LEN, body, len);
    assert_int_equal(send(c->fd, bytes, DX_WIRE_HEADER_LEN + len, MSG_NOSIGNAL),
                     DX_WIRE_HEADER_LEN + len);
}

static inline void client_hello(struct client *c, uint16_t major, uint32_t encodings)
{
    struct dx_msg_hello m = {.major = major, .minor = DX_WIRE_MINOR, .encodings = encodings};
    uint8_t body[256];
    struct dx_writer w = dx_writer_init(body, sizeof(body));

    dx_msg_hello_put(&w, &m);
    client_send(c, DX_MSG_HELLO, body, (size_t)(w.p - body));
}

static inline void client_subscribe(struct client *c, const struct dx_msg_subscribe *m)
{
    uint8_t body[256];
    struct dx_writer w = dx_writer_init(body, sizeof(body));

    c->asked = *m;
    dx_msg_subscribe_put(&w, m);
    client_send(c, DX_MSG_SUBSCRIBE, body, (size_t)(w.p - body));
}

/* Connected, HELLO and SUBSCRIBE sent. */
static inline struct client *client_start(struct fixture *fx, const struct dx_msg_subscribe *m)
{
    static const struct dx_msg_subscribe plain;
    struct client *c = client_connect(fx);

    client_hello(c, DX_WIRE_MAJOR, 3);
    client_subscribe(c, m ? m : &plain);
    return c;
}

static inline bool client_read(struct client *c, uint8_t *to, size_t len)
{
    while (len) {
        ssize_t n = recv(c->fd, to, c->slow_reader ? 1 : len, 0);

        if (n < 0 && (errno == EAGAIN || errno == EINTR))
            fail_msg("the server is silent");
        if (n <= 0)
            return false;
        to += n;
        len -= (size_t)n;
    }
    return true;
}

static inline bool client_in_region(const struct client *c, uint32_t t)
{
    const struct dx_msg_subscribe *m = &c->asked;
    uint32_t row = t / c->told.tile_cols, col = t % c->told.tile_cols;

    return !m->n_tile_rows ||
           (row >= m->tile_row0 && row < (uint32_t)m->tile_row0 + m->n_tile_rows &&
            col >= m->tile_col0 && col < (uint32_t)m->tile_col0 + m->n_tile_cols);
}

static inline void client_on_tile(struct client *c, const struct dx_wire_header *h)
{
    static __thread uint8_t expected[DX_WIRE_MAX_BODY];
    uint32_t t = dx_get_u16(c->body) * c->told.tile_cols + (uint32_t)dx_get_u16(c->body + 2);
    uint64_t version =
        h->length > DX_CHUNK_HEADER_LEN ? dx_get_u64(c->body + DX_CHUNK_HEADER_LEN) : 0;
    size_t len;

    assert_true(c->in_snapshot || c->had_snapshot);
    assert_true(client_in_region(c, t));
    assert_true(c->n_tiles == 0 || c->batch_epoch == h->epoch);
    len = fixture_body(expected, version, c->asked.encoding, c->told.tile_cols, t, c->fx->body_len,
                       c->asked.want_attr ? c->fx->attr_bytes : 0);
    assert_int_equal(h->length, len);
    assert_memory_equal(c->body, expected, len);
    c->batch_epoch = h->epoch;
    c->held[t] = version;
    c->n_tiles++;
}

static inline void client_on_commit(struct client *c, const struct dx_wire_header *h)
{
    assert_int_equal(dx_msg_commit_get(&c->commit, c->body, h->length), 0);
    assert_true(c->in_snapshot || c->had_snapshot);
    assert_int_equal(c->commit.n_tiles, c->n_tiles);
    assert_true(c->n_tiles == 0 || c->batch_epoch == h->epoch);
    assert_true(h->epoch > c->epoch);
    for (uint32_t t = 0; t < (uint32_t)c->told.tile_rows * c->told.tile_cols; t++)
        assert_int_equal(c->held[t],
                         client_in_region(c, t) ? fixture_version(c->commit.frame, t) : 0);
    c->epoch = h->epoch;
    c->n_tiles = 0;
    c->n_commits++;
}

static inline void client_on_geometry(struct client *c, const struct dx_wire_header *h)
{
    struct dx_msg_geometry m;

    assert_int_equal(dx_msg_geometry_get(&m, c->body, h->length), 0);
    assert_int_equal(m.offset, c->geometry_len);
    assert_int_equal(m.total, c->told.table_bytes);
    for (uint32_t k = 0; k < m.len / 4; k++)
        assert_int_equal(dx_get_u32(m.bytes + 4 * k),
                         dx_f32_bits((float)(m.offset / 4 + k) * 0.25f));
    c->geometry_len += m.len;
}

static inline void client_on_reset(struct client *c, const struct dx_wire_header *h)
{
    assert_int_equal(dx_msg_reset_get(&c->reset, c->body, h->length), 0);
    assert_true(c->subscribed);
    c->subscribed = c->in_snapshot = c->had_snapshot = false;
    c->n_tiles = 0;
    memset(c->held, 0, sizeof(c->held));
    c->n_resets++;
}

static inline void client_handle(struct client *c, const struct dx_wire_header *h)
{
    switch (h->type) {
    case DX_MSG_WELCOME:
        assert_false(c->welcome);
        c->welcome = true;
        break;
    case DX_MSG_ERROR:
        assert_int_equal(dx_msg_error_get(&c->error, c->body, h->length), 0);
        break;
    case DX_MSG_SUBSCRIBED:
        assert_true(c->welcome && !c->subscribed);
        assert_int_equal(dx_msg_subscribed_get(&c->told, c->body, h->length), 0);
        c->subscribed = true;
        c->geometry_len = 0;
        break;
    case DX_MSG_GEOMETRY:
        client_on_geometry(c, h);
        break;
    case DX_MSG_TILE:
        client_on_tile(c, h);
        break;
    case DX_MSG_COMMIT:
        client_on_commit(c, h);
        break;
    case DX_MSG_RESET:
        client_on_reset(c, h);
        break;
    case DX_MSG_SNAPSHOT_BEGIN:
        assert_true(c->subscribed && !c->had_snapshot && c->geometry_len == c->told.table_bytes);
        c->in_snapshot = true;
        break;
    case DX_MSG_SNAPSHOT_END:
        assert_true(c->in_snapshot && c->n_commits > 0);
        c->in_snapshot = false;
        c->had_snapshot = true;
        break;
    case DX_MSG_STREAM_STATE:
        assert_int_equal(c->n_tiles, 0);
        assert_int_equal(dx_msg_stream_state_get(&c->state, c->body, h->length), 0);
        break;
    default:
        fail_msg("message of type %u", h->type);
    }
}

/* One message; its type, or 0 when the server has closed. */
static inline int client_step(struct client *c)
{
    uint8_t head[DX_WIRE_HEADER_LEN];
    struct dx_wire_header h;

    if (!client_read(c, head, sizeof(head)))
        return 0;
    dx_wire_get_header(&h, head);
    assert_true(h.length <= DX_WIRE_MAX_BODY);
    assert_int_equal(h.seq, c->seq++);
    if (!client_read(c, c->body, h.length))
        return 0;
    client_handle(c, &h);
    return h.type;
}

/* Until the server has said this; fails when it closes before. */
static inline void client_until(struct client *c, int type)
{
    int got;

    do {
        got = client_step(c);
        if (got == 0)
            fail_msg("the server closed: %u %s", c->error.code, c->error.text);
    } while (got != type);
}

/* Until a COMMIT of this frame, and what ends its batch. */
static inline void client_until_frame(struct client *c, uint64_t frame)
{
    do
        client_until(c, DX_MSG_COMMIT);
    while (c->commit.frame < frame);
    assert_int_equal(c->commit.frame, frame);
    if (c->in_snapshot)
        client_until(c, DX_MSG_SNAPSHOT_END);
}

/* Until the server closes; its ERROR is then in c->error. */
static inline void client_until_closed(struct client *c)
{
    while (client_step(c))
        ;
}

static inline void client_expect_error(struct client *c, enum dx_wire_error code)
{
    client_until_closed(c);
    assert_int_equal(c->error.code, code);
    client_close(c);
}

#endif
