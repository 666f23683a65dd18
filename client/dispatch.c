/*
 * What each message of the server means, and when it may come. A handler returns 0, a callback's
 * value, or an error that it made sticky with dx_session_fail. One thread at a time.
 */
#include "client/session.h"

#include <errno.h>

struct message {
    struct dx_wire_header header;
    const uint8_t *body;
    size_t len;
};

#define PHASE(p)  (1u << DX_PHASE_##p)
#define ANY_PHASE 0xffffffffu

static int refuse(struct dexel *d, const char *what)
{
    return dx_session_fail(d, dx_err_set(&d->err, -EPROTO, "message %u of the server: %s",
                                         d->connection.seq_in - 1, what));
}

static int on_welcome(struct dexel *d, const struct message *m)
{
    struct dx_msg_welcome w;
    int r;

    if (dx_msg_welcome_get(&w, m->body, m->len) < 0)
        return refuse(d, "not a WELCOME of a dexeld");
    if (w.major != DX_WIRE_MAJOR || dx_wire_minor(w.minor) != w.minor)
        return dx_session_fail(
            d, dx_err_set(&d->err, -EPROTO, "%s speaks protocol %u.%u, expected %u.%u or less",
                          w.server, w.major, w.minor, DX_WIRE_MAJOR, DX_WIRE_MINOR));
    r = dx_connection_set_max_body(&d->connection, w.max_body);
    if (r < 0)
        return dx_session_fail(d, dx_err_set(&d->err, r, "a buffer of %u bytes", w.max_body));
    d->phase = DX_PHASE_SUBSCRIBED;
    return dx_reconnect_welcomed(d);
}

/* It stops, or has no room for us now: another connection may be served. */
static bool may_change(const struct dx_msg_error *e)
{
    return e->code == DX_WIRE_E_LIMIT || e->code == DX_WIRE_E_SLOW || e->code == DX_WIRE_E_SHUTDOWN;
}

static int on_error(struct dexel *d, const struct message *m)
{
    struct dx_msg_error e;

    if (dx_msg_error_get(&e, m->body, m->len) < 0)
        return refuse(d, "not an ERROR");
    dx_err_set(&d->err, -EPROTO, "the server: %s (error %u)", e.text, e.code);
    return dx_session_fail(d, d->again.poll_fd >= 0 && may_change(&e) ? -ECONNRESET : -EPROTO);
}

static int call_stream(struct dexel *d)
{
    const struct dx_msg_subscribed *m = &d->told;
    struct dexel_stream s = {
        .name = m->stream,
        .model = (enum dexel_model)m->model,
        .height = m->height,
        .width = m->width,
        .tile_rows = m->tile_rows,
        .tile_cols = m->tile_cols,
        .wrap = m->wrap,
        .flip = m->flip,
        .attr_bytes = m->attr_bytes,
        .normals = m->normals,
        .smoothed = m->smooth,
        .unit_m = (double)m->unit_m,
        .tilt_deg = m->tilt_deg,
        .noise_k = m->noise_k,
        .cap_m = m->cap_m,
        .lod_sigma = (double)m->lod.bound / DX_LOD_PER_SIGMA,
        .stride = m->lod.stride,
    };

    memcpy(s.pose, m->pose, sizeof(s.pose));
    memcpy(s.sigma, m->sigma, sizeof(s.sigma));
    return d->callbacks.stream ? d->callbacks.stream(d->user, &s) : 0;
}

static int on_subscribed(struct dexel *d, const struct message *m)
{
    int r;

    if (dx_msg_subscribed_get(&d->told, m->body, m->len) < 0)
        return refuse(d, "not a SUBSCRIBED, or a value in it is out of range");
    if (d->told.encoding != d->asked.encoding || d->told.mode != d->asked.mode ||
        !dx_lod_same(d->told.lod, d->asked.lod))
        return refuse(d, "SUBSCRIBED with another encoding, mode or level than asked for");
    dx_reconnect_served(d);
    d->stream = m->header.stream;
    dx_tiling_init(&d->tiling, d->told.height, d->told.width, d->told.wrap);
    r = dx_session_begin_geometry(d);
    if (r < 0)
        return r;
    d->phase = d->told.table_bytes ? DX_PHASE_GEOMETRY : DX_PHASE_SNAPSHOT;
    return call_stream(d);
}

static int on_geometry(struct dexel *d, const struct message *m)
{
    struct dx_msg_geometry piece;
    int r;

    if (dx_msg_geometry_get(&piece, m->body, m->len) < 0)
        return refuse(d, "not a piece of GEOMETRY");
    r = dx_session_add_geometry(d, &piece);
    if (r == 0 && d->geometry_len == d->told.table_bytes)
        d->phase = DX_PHASE_SNAPSHOT;
    return r;
}

static int on_tile(struct dexel *d, const struct message *m)
{
    if (d->n_tiles && m->header.epoch != d->epoch)
        return refuse(d, "TILE of another epoch than those before it");
    d->epoch = m->header.epoch;
    d->n_tiles++;
    return dx_session_tile(d, m->body, m->len);
}

static int on_commit(struct dexel *d, const struct message *m)
{
    struct dx_msg_commit c;
    struct dexel_commit commit;

    if (dx_msg_commit_get(&c, m->body, m->len) < 0)
        return refuse(d, "not a COMMIT");
    if (c.n_tiles != d->n_tiles || (d->n_tiles && m->header.epoch != d->epoch))
        return refuse(d, "COMMIT of other tiles than those before it");
    commit = (struct dexel_commit){
        .epoch = m->header.epoch,
        .frame = c.frame,
        .host_ns = c.host_ns,
        .device_ns = c.device_ns,
        .clock_id = c.clock_id,
        .n_dropped = c.n_dropped,
        .n_tiles = c.n_tiles,
        .partial = (c.flags & DX_COMMIT_PARTIAL) != 0,
        .snapshot = d->phase == DX_PHASE_TILES,
        .cap_first = (c.flags & DX_COMMIT_CAP_FIRST) != 0,
        .cap_last = (c.flags & DX_COMMIT_CAP_LAST) != 0,
    };
    d->n_tiles = 0;
    d->n_asked -= d->n_asked > 0;
    if (d->phase == DX_PHASE_TILES)
        d->phase = DX_PHASE_COMMITTED;
    return d->callbacks.commit ? d->callbacks.commit(d->user, &commit) : 0;
}

static int on_reset(struct dexel *d, const struct message *m)
{
    struct dx_msg_reset reset;

    if (dx_msg_reset_get(&reset, m->body, m->len) < 0)
        return refuse(d, "not a RESET");
    d->phase = DX_PHASE_SUBSCRIBED;
    d->n_tiles = 0;
    return d->callbacks.reset ? d->callbacks.reset(d->user, reset.reason) : 0;
}

static int on_snapshot(struct dexel *d, const struct message *m)
{
    if (m->len)
        return refuse(d, "a snapshot message with a body");
    d->phase = m->header.type == DX_MSG_SNAPSHOT_BEGIN ? DX_PHASE_TILES : DX_PHASE_LIVE;
    return 0;
}

static int on_stream_state(struct dexel *d, const struct message *m)
{
    struct dx_msg_stream_state s;

    if (dx_msg_stream_state_get(&s, m->body, m->len) < 0)
        return refuse(d, "not a STREAM_STATE");
    if (d->n_tiles)
        return refuse(d, "STREAM_STATE inside a batch");
    d->ended = s.state == DX_STREAM_ENDED;
    d->again.is_told = false; /* what is told last is not any more that there is none */
    return d->callbacks.state ? d->callbacks.state(d->user, (enum dexel_state)s.state, s.reason)
                              : 0;
}

static const struct handler {
    uint16_t type;
    const char *name;
    uint32_t phases;
    int (*handle)(struct dexel *d, const struct message *m);
} handlers[] = {
    {DX_MSG_WELCOME, "WELCOME", PHASE(WELCOME), on_welcome},
    {DX_MSG_ERROR, "ERROR", ANY_PHASE, on_error},
    {DX_MSG_SUBSCRIBED, "SUBSCRIBED", PHASE(SUBSCRIBED), on_subscribed},
    {DX_MSG_GEOMETRY, "GEOMETRY", PHASE(GEOMETRY), on_geometry},
    {DX_MSG_TILE, "TILE", PHASE(TILES) | PHASE(LIVE), on_tile},
    {DX_MSG_COMMIT, "COMMIT", PHASE(TILES) | PHASE(LIVE), on_commit},
    {DX_MSG_RESET, "RESET", ANY_PHASE & ~PHASE(WELCOME), on_reset},
    {DX_MSG_SNAPSHOT_BEGIN, "SNAPSHOT_BEGIN", PHASE(SNAPSHOT), on_snapshot},
    {DX_MSG_SNAPSHOT_END, "SNAPSHOT_END", PHASE(COMMITTED), on_snapshot},
    {DX_MSG_STREAM_STATE, "STREAM_STATE", ANY_PHASE & ~PHASE(WELCOME), on_stream_state},
};

static const struct handler *find_handler(uint16_t type)
{
    for (size_t i = 0; i < sizeof(handlers) / sizeof(handlers[0]); i++)
        if (handlers[i].type == type)
            return &handlers[i];
    return NULL;
}

static int handle(struct dexel *d, const struct message *m)
{
    const struct handler *h = find_handler(m->header.type);

    if (!h && (m->header.flags & DX_WIRE_SKIPPABLE))
        return 0;
    if (!h)
        return dx_session_fail(d, dx_err_set(&d->err, -EPROTO,
                                             "message %u of the server: unknown type %u",
                                             m->header.seq, m->header.type));
    if (!(h->phases & 1u << d->phase))
        return dx_session_fail(d, dx_err_set(&d->err, -EPROTO,
                                             "message %u of the server: %s out of order",
                                             m->header.seq, h->name));
    if (h->phases != ANY_PHASE && d->stream != DX_WIRE_NO_STREAM && m->header.stream != d->stream)
        return dx_session_fail(d, dx_err_set(&d->err, -EPROTO,
                                             "message %u of the server: %s of stream %u, not %u",
                                             m->header.seq, h->name, m->header.stream, d->stream));
    return h->handle(d, m);
}

int dx_session_dispatch(struct dexel *d)
{
    for (;;) {
        struct message m;
        int r = dx_connection_next(&d->connection, &m.header, &m.body, &d->err);

        if (r < 0)
            return dx_session_fail(d, r);
        if (r != DX_CONNECTION_MESSAGE)
            return 0;
        m.len = m.header.length;
        r = handle(d, &m);
        if (r != 0)
            return r;
    }
}
