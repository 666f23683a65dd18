/*
 * Fuzzes all that a peer's bytes can reach: chunks of all encodings, the bodies of all messages,
 * and libdexel's dispatcher. The first byte chooses which. Seeds: seeds_wire.c.
 */
#include <stdio.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <unistd.h>

#include "client/session.h"
#include "core/base/hash.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
const char *__asan_default_options(void);

/* A geometry of 2^28 dexels may be announced: its allocation then fails, as it would under a limit.
 */
const char *__asan_default_options(void)
{
    return "allocator_may_return_null=1:max_allocation_size_mb=64";
}

static volatile uint64_t sink; /* what callbacks were given was all readable */

static void require(bool ok, const char *what)
{
    if (ok)
        return;
    fprintf(stderr, "fuzz_wire: %s\n", what);
    abort();
}

/* ---- chunks -----------------------------------------------------------------------------------
 */

static void fuzz_chunk(const uint8_t *data, size_t size)
{
    static struct dx_geometry *geometry[2];
    static struct dx_tile_mesh mesh;
    struct dx_tiling t;
    bool wrap;

    if (size < 1)
        return;
    wrap = data[0] & 1;
    /* two tiles by two; the last ones are 6 x 26 cells, or 6 x 25 */
    if (!geometry[wrap])
        require(dx_geometry_new_spinning(&geometry[wrap], 71, 90, 0,
                                         wrap ? 6.283185307179586 / 90 : 0.01, 0, 0.01) == 0,
                "no geometry");
    dx_tiling_init(&t, 71, 90, wrap);
    if (dx_chunk_get(&mesh, data + 1, size - 1, &t, geometry[wrap]) < 0)
        return;
    require(mesh.row < t.rows && mesh.col < t.cols, "a tile outside the grid");
    require(mesh.n_vertices <= DX_TILE_MAX_VERTICES && mesh.n_triangles <= DX_TILE_MAX_TRIANGLES,
            "too large a mesh");
    for (uint32_t i = 0; i < 3 * mesh.n_triangles; i++)
        require(mesh.index[i] < mesh.n_vertices, "an index out of range");
    for (uint32_t i = 0; mesh.has_normals && mesh.n_triangles && i < 2 * mesh.n_vertices; i++)
        require(mesh.normal[i] >= -127, "a normal out of range");
    for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
        if (mesh.mask[k / 8] >> (k % 8) & 1)
            require(dx_tile_vertex_id(&t, mesh.row, mesh.col, k) < 71 * 90, "a vertex outside");
}

/* ---- messages: what was taken can be said again, and is taken again -----------------------------
 */

#define AGAIN(name)                                                                                \
    static void fuzz_##name(const uint8_t *data, size_t size)                                      \
    {                                                                                              \
        static uint8_t body[DX_WIRE_MAX_BODY];                                                     \
        struct dx_writer w = dx_writer_init(body, sizeof(body));                                   \
        struct dx_msg_##name m;                                                                    \
        if (dx_msg_##name##_get(&m, data, size) < 0)                                               \
            return;                                                                                \
        dx_msg_##name##_put(&w, &m);                                                               \
        require(!w.failed && dx_msg_##name##_get(&m, body, (size_t)(w.p - body)) == 0,             \
                #name " not taken again");                                                         \
    }

AGAIN(hello)
AGAIN(welcome)
AGAIN(error)
AGAIN(subscribe)
AGAIN(subscribed)
AGAIN(geometry)
AGAIN(commit)
AGAIN(reset)
AGAIN(stream_state)

/* ---- the dispatcher -----------------------------------------------------------------------------
 */

static int on_stream(void *user, const struct dexel_stream *s)
{
    (void)user;
    sink += dx_hash(0, s->name, strlen(s->name));
    require(s->height >= 2 && s->width >= 2 && s->attr_bytes <= 2, "a bad stream");
    return 0;
}

static int on_text(void *user, const char *reason)
{
    (void)user;
    sink += dx_hash(0, reason, strlen(reason));
    return 0;
}

static int on_tile(void *user, const struct dexel_tile *t)
{
    int *n_tiles = user;

    sink += dx_hash(0, t->xyz, 12 * (size_t)t->n_vertices);
    sink += dx_hash(0, t->dexel, 4 * (size_t)t->n_vertices);
    if (t->attr)
        sink += dx_hash(0, t->attr, 2 * (size_t)t->n_vertices);
    if (t->normal)
        sink += dx_hash(0, t->normal, 12 * (size_t)t->n_vertices);
    for (uint32_t i = 0; i < 3 * t->n_triangles; i++)
        require(t->index[i] < t->n_vertices, "an index out of range");
    return ++*n_tiles % 4 == 3; /* stops the dispatch now and then */
}

static int on_raw_tile(void *user, const uint8_t *chunk, size_t len)
{
    (void)user;
    sink += dx_hash(0, chunk, len);
    return 0;
}

static int on_commit(void *user, const struct dexel_commit *c)
{
    (void)user;
    sink += c->epoch;
    return 0;
}

static int on_state(void *user, enum dexel_state state, const char *reason)
{
    (void)user;
    require(state <= DEXEL_FAULTED, "an unknown state");
    sink += dx_hash(0, reason, strlen(reason));
    return 0;
}

struct session {
    struct dexel *client;
    int server, n_tiles;
};

static void session_open(struct session *s, uint8_t flags)
{
    const struct dexel_callbacks callbacks = {on_stream,   on_text,   on_tile,
                                              on_raw_tile, on_commit, on_state};
    struct dexel_options options = {.encoding = (enum dexel_encoding)(flags % 3),
                                    .mode = flags / 3 & 1 ? DEXEL_PULL : DEXEL_LIVE,
                                    .want_attr = 1,
                                    .want_normals = 1};
    int pair[2];

    s->n_tiles = 0;
    require(dx_session_new(&s->client, &options, &callbacks, &s->n_tiles) == 0, "no session");
    require(socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, pair) == 0, "no socketpair");
    s->client->connection.fd = pair[0];
    s->server = pair[1];
    require(dx_session_hello(s->client) == 0, "no HELLO");
}

/* Sends and dispatches, by turns; false when the client has had enough. */
static bool session_say(struct session *s, const uint8_t *bytes, size_t len, size_t step)
{
    while (len) {
        ssize_t n = send(s->server, bytes, len < step ? len : step, MSG_NOSIGNAL);

        if (n > 0) {
            bytes += n;
            len -= (size_t)n;
        }
        if (dexel_dispatch(s->client) < 0)
            return false;
        if (s->client->asked.mode == DX_MODE_PULL && s->n_tiles == 1)
            dexel_next(s->client);
    }
    return true;
}

static void session_close(struct session *s)
{
    close(s->server);
    while (dexel_dispatch(s->client) >= 0)
        ;
    require(*dexel_error(s->client) != 0, "an error without a text");
    dexel_close(s->client);
}

/* Bytes as they are. */
static void fuzz_dispatch_raw(const uint8_t *data, size_t size)
{
    struct session s;

    if (size < 2)
        return;
    session_open(&s, data[0]);
    session_say(&s, data + 2, size - 2, 1 + 8 * (size_t)data[1]);
    session_close(&s);
}

/* Bodies with a short head (type, flags, epoch, u16 length); the framing is made right. */
static void fuzz_dispatch_framed(const uint8_t *data, size_t size)
{
    struct session s;
    struct dx_wire_header h = {.stream = 1};
    uint8_t header[DX_WIRE_HEADER_LEN];

    if (size < 1)
        return;
    session_open(&s, data[0]);
    for (data++, size--; size >= 5; h.seq++) {
        h.type = data[0];
        h.flags = data[1];
        h.epoch = data[2];
        h.length = dx_get_u16(data + 3);
        data += 5;
        size -= 5;
        if (h.length > size)
            h.length = (uint32_t)size;
        dx_wire_put_header(header, &h);
        if (!session_say(&s, header, sizeof(header), sizeof(header)) ||
            !session_say(&s, data, h.length, h.length))
            break;
        data += h.length;
        size -= h.length;
    }
    session_close(&s);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static void (*const targets[])(const uint8_t *data, size_t size) = {
        fuzz_chunk,    fuzz_dispatch_raw, fuzz_dispatch_framed, fuzz_hello,
        fuzz_welcome,  fuzz_error,        fuzz_subscribe,       fuzz_subscribed,
        fuzz_geometry, fuzz_commit,       fuzz_reset,           fuzz_stream_state,
    };

    if (size < 1)
        return 0;
    targets[data[0] % (sizeof(targets) / sizeof(targets[0]))](data + 1, size - 1);
    return 0;
}
