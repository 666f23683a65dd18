/*
 * A raw client of the server under test: speaks bytes, holds the server to the protocol (order,
 * numbering), and after each COMMIT to exactly the mesh of its frame.
 */
#ifndef SERVER_CLIENT_H
#define SERVER_CLIENT_H

#include "tests/unit/server_fixture.h"

/* ---- a raw client
 * -------------------------------------------------------------------------------- */

struct client {
    struct fixture *fx;
    int fd;
    uint32_t seq;
    struct dx_msg_subscribe asked;
    bool welcome, subscribed, in_snapshot, had_snapshot;
    struct dx_msg_welcome greeting;
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
    struct timeval t = {.tv_sec = 300};
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

static inline void client_hello_of(struct client *c, uint16_t major, uint16_t minor,
                                   uint32_t encodings)
{
    struct dx_msg_hello m = {.major = major, .minor = minor, .encodings = encodings};
    uint8_t body[256];
    struct dx_writer w = dx_writer_init(body, sizeof(body));

    dx_msg_hello_put(&w, &m);
    client_send(c, DX_MSG_HELLO, body, (size_t)(w.p - body));
}

static inline void client_hello(struct client *c, uint16_t major, uint32_t encodings)
{
    client_hello_of(c, major, DX_WIRE_MINOR, encodings);
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

    client_hello(c, DX_WIRE_MAJOR, (1u << DX_N_ENCODINGS) - 1);
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
    uint8_t keep = (uint8_t)((c->asked.want & DX_WANT_ATTR ? 3u : 0) |
                             (c->asked.want & DX_WANT_NORMALS ? DX_CHUNK_NORMALS : 0));
    uint8_t sections = fixture_sections(c->fx) & keep;
    size_t at = DX_CHUNK_HEADER_LEN + (sections & 3u) * (size_t)dx_get_u16(c->body + 6), len;
    uint64_t version = h->length > DX_CHUNK_HEADER_LEN ? dx_get_u64(c->body + at) : 0;

    assert_true(c->in_snapshot || c->had_snapshot);
    assert_true(client_in_region(c, t));
    assert_true(c->n_tiles == 0 || c->batch_epoch == h->epoch);
    len = fixture_body(expected, version, c->asked.encoding, c->told.tile_cols, t, c->fx->body_len,
                       sections);
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
    for (uint32_t k = 0; k < m.len / 4; k++) {
        const uint32_t number = m.offset / 4 + k;

        assert_int_equal(dx_get_u32(m.bytes + 4 * k), dx_f32_bits((float)number * 0.25f));
    }
    c->geometry_len += m.len;
}

static inline void client_on_reset(struct client *c, const struct dx_wire_header *h)
{
    assert_int_equal(dx_msg_reset_get(&c->reset, c->body, h->length), 0);
    assert_true(c->subscribed);
    c->subscribed = c->in_snapshot = c->had_snapshot = false;
    c->n_tiles = 0;
    c->epoch = 0; /* one may come again */
    memset(c->held, 0, sizeof(c->held));
    c->n_resets++;
}

static inline void client_handle(struct client *c, const struct dx_wire_header *h)
{
    switch (h->type) {
    case DX_MSG_WELCOME:
        assert_false(c->welcome);
        assert_int_equal(dx_msg_welcome_get(&c->greeting, c->body, h->length), 0);
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
