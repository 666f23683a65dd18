/*
 * The public functions of libdexel: making and ending a subscription, and the two ways to drive it.
 * One thread at a time.
 */
#include "client/session.h"

#include <errno.h>
#include <poll.h>
#include <stdlib.h>

#define DEFAULT_SOCKET "/run/dexeld/mesh.sock"

static int check_level(struct dexel *d, const struct dexel_options *o)
{
    const char *bad = dx_lod_level_set(&d->asked.lod, o->lod_sigma, o->stride);

    if (bad)
        return dx_err_set(&d->err, -EINVAL, "level of detail %g, stride %u: %s", o->lod_sigma,
                          o->stride, bad);
    if (!dx_lod_is_whole(d->asked.lod) && o->encoding != DEXEL_F32)
        return dx_err_set(&d->err, -EINVAL, "a level of detail comes as f32 only");
    return 0;
}

static int check_options(struct dexel *d, const struct dexel_options *o)
{
    if (o->encoding > DEXEL_DELTA || o->mode > DEXEL_LOSSLESS)
        return dx_err_set(&d->err, -EINVAL, "encoding %d, mode %d: at most %d and %d expected",
                          o->encoding, o->mode, DEXEL_DELTA, DEXEL_LOSSLESS);
    if (o->stream && strlen(o->stream) >= DX_WIRE_NAME)
        return dx_err_set(&d->err, -EINVAL, "a stream's name has at most %d bytes",
                          DX_WIRE_NAME - 1);
    if (!o->n_tile_rows != !o->n_tile_cols)
        return dx_err_set(&d->err, -EINVAL, "a region of %u x %u tiles: both or none expected",
                          o->n_tile_rows, o->n_tile_cols);
    return check_level(d, o);
}

int dx_session_new(struct dexel **out, const struct dexel_options *options,
                   const struct dexel_callbacks *callbacks, void *user)
{
    static const struct dexel_options defaults;
    const struct dexel_options *o = options ? options : &defaults;
    struct dexel *d = calloc(1, sizeof(*d));
    int r;

    *out = NULL;
    if (!d)
        return -ENOMEM;
    r = dx_connection_init(&d->connection);
    if (r < 0) {
        free(d);
        return r;
    }
    *out = d;
    d->callbacks = *callbacks;
    d->user = user;
    d->stream = DX_WIRE_NO_STREAM;
    dx_reconnect_init(&d->again);
    r = check_options(d, o);
    if (r < 0)
        return dx_session_fail(d, r);
    d->asked = (struct dx_msg_subscribe){
        .encoding = (uint8_t)o->encoding,
        .mode = (uint8_t)o->mode,
        .want =
            (uint8_t)((o->want_attr ? DX_WANT_ATTR : 0) | (o->want_normals ? DX_WANT_NORMALS : 0)),
        .min_interval_ms = o->min_interval_ms,
        .tile_row0 = o->tile_row0,
        .tile_col0 = o->tile_col0,
        .n_tile_rows = o->n_tile_rows,
        .n_tile_cols = o->n_tile_cols,
        .lod = d->asked.lod,
    };
    if (o->stream)
        memcpy(d->asked.stream, o->stream, strlen(o->stream));
    return 0;
}

void dx_session_free(struct dexel *d)
{
    if (!d)
        return;
    dx_geometry_unref(d->geometry);
    dx_connection_fini(&d->connection);
    dx_reconnect_fini(&d->again);
    free(d);
}

int dx_session_restart(struct dexel *d)
{
    dx_connection_fini(&d->connection);
    dx_geometry_unref(d->geometry);
    d->geometry = NULL;
    d->geometry_len = 0;
    d->phase = DX_PHASE_WELCOME;
    d->ended = false;
    d->failed = 0;
    d->stream = DX_WIRE_NO_STREAM;
    d->n_tiles = 0;
    return dx_connection_init(&d->connection);
}

int dx_session_fail(struct dexel *d, int error)
{
    d->failed = error;
    return error;
}

int dx_session_hello(struct dexel *d)
{
    const struct dx_msg_hello hello = {
        .major = DX_WIRE_MAJOR, .minor = DX_WIRE_MINOR, .encodings = (1u << DX_N_ENCODINGS) - 1};
    uint8_t body[256];
    struct dx_writer w = dx_writer_init(body, sizeof(body));
    int r;

    dx_msg_hello_put(&w, &hello);
    r = dx_connection_send(&d->connection, DX_MSG_HELLO, body, (size_t)(w.p - body));
    if (r < 0)
        return r;
    w = dx_writer_init(body, sizeof(body));
    dx_msg_subscribe_put(&w, &d->asked);
    return dx_connection_send(&d->connection, DX_MSG_SUBSCRIBE, body, (size_t)(w.p - body));
}

static const char *path_of(const struct dexel_options *options)
{
    const char *path = options ? options->socket : NULL;

    if (!path)
        path = getenv("DEXELD_SOCKET");
    return path && *path ? path : DEFAULT_SOCKET;
}

int dexel_open(struct dexel **out, const struct dexel_options *options,
               const struct dexel_callbacks *callbacks, void *user)
{
    const char *path = path_of(options);
    int r = dx_session_new(out, options, callbacks, user);

    if (r < 0)
        return r;
    if (options && options->reconnect) {
        r = dx_reconnect_start(*out, path);
        return r < 0 ? dx_session_fail(*out, r) : 0;
    }
    r = dx_connection_open(&(*out)->connection, path, DX_CONNECTION_WAIT, &(*out)->err);
    if (r < 0)
        return dx_session_fail(*out, r);
    r = dx_session_hello(*out);
    if (r < 0)
        return dx_session_fail(*out, dx_err_set(&(*out)->err, r, "%s: %s", path, strerror(-r)));
    return 0;
}

void dexel_close(struct dexel *d)
{
    dx_session_free(d);
}

int dexel_fd(const struct dexel *d)
{
    return d->again.poll_fd >= 0 ? d->again.poll_fd : d->connection.fd;
}

short dexel_events(const struct dexel *d)
{
    return d->connection.out_len && d->again.poll_fd < 0 ? POLLIN | POLLOUT : POLLIN;
}

int dx_session_turn(struct dexel *d)
{
    int r = dx_connection_flush(&d->connection);
    if (r < 0)
        return dx_session_fail(d, dx_err_set(&d->err, r, "writing: %s", strerror(-r)));
    r = dx_session_dispatch(d);
    if (r != 0)
        return r;
    r = dx_connection_fill(&d->connection, &d->err);
    if (r < 0)
        return dx_session_fail(d, r);
    return r == DX_CONNECTION_BYTES ? dx_session_dispatch(d) : 0;
}

int dexel_dispatch(struct dexel *d)
{
    if (d->failed)
        return d->failed;
    return d->again.poll_fd >= 0 ? dx_reconnect_dispatch(d) : dx_session_turn(d);
}

int dexel_run(struct dexel *d, int timeout_ms)
{
    for (;;) {
        struct pollfd p;
        int r = dexel_dispatch(d);

        if (r != 0 || d->ended)
            return r;
        p = (struct pollfd){.fd = dexel_fd(d), .events = dexel_events(d)};
        r = poll(&p, 1, timeout_ms);
        if (r < 0)
            return dx_err_set(&d->err, -errno, "poll: %s", strerror(errno));
        if (r == 0)
            return dx_err_set(&d->err, -ETIMEDOUT, "nothing from the server for %d ms", timeout_ms);
    }
}

int dexel_next(struct dexel *d)
{
    int r;

    if (d->failed)
        return d->failed;
    if (d->asked.mode != DX_MODE_PULL)
        return dx_err_set(&d->err, -EINVAL, "dexel_next: the subscription is not in pull mode");
    r = d->connection.fd < 0 ? 0 : dx_connection_send(&d->connection, DX_MSG_NEXT, NULL, 0);
    d->n_asked += r == 0; /* a new connection is asked for what the last one left */
    return r < 0 ? dx_err_set(&d->err, r, "NEXT: %s", strerror(-r)) : 0;
}

const char *dexel_error(const struct dexel *d)
{
    if (!d)
        return "out of memory";
    return d->err.text[0] ? d->err.text : "no error";
}

const char *dexel_version(void)
{
    return DEXELD_VERSION;
}
