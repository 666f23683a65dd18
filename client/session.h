/*
 * Inside libdexel: what one subscription knows. Belongs to the thread that drives the connection.
 */
#ifndef DX_SESSION_H
#define DX_SESSION_H

#include "client/connection.h"
#include "client/dexel.h"
#include "client/reconnect.h"
#include "core/wire/chunk.h"

/* Where the session is: what the server may say next (docs/protocol.md, "States"). */
enum dx_phase {
    DX_PHASE_WELCOME = 0,
    DX_PHASE_SUBSCRIBED, /* waiting for it: at first, and after RESET */
    DX_PHASE_GEOMETRY,
    DX_PHASE_SNAPSHOT,  /* waiting for its begin */
    DX_PHASE_TILES,     /* in the snapshot, before its commit */
    DX_PHASE_COMMITTED, /* waiting for the snapshot's end */
    DX_PHASE_LIVE,
};

struct dexel {
    struct dx_connection connection;
    struct dexel_callbacks callbacks;
    void *user;
    enum dx_phase phase;
    bool ended; /* the stream; until it says otherwise */
    int failed; /* sticky: the error that ended the connection */
    struct dx_err err;
    struct dx_reconnect again;

    uint32_t stream; /* number, from SUBSCRIBED; DX_WIRE_NO_STREAM before */
    struct dx_msg_subscribe asked;
    struct dx_msg_subscribed told;
    struct dx_tiling tiling;
    struct dx_geometry *geometry; /* q16 and delta only */
    uint32_t geometry_len;        /* bytes of its table that came */

    uint32_t n_asked; /* pull mode: NEXTs whose batch has not come, over all connections */

    uint32_t n_tiles; /* of the open batch, so far */
    uint64_t epoch;   /* of the open batch, when n_tiles is not 0 */

    struct dx_tile_mesh mesh;
    uint32_t vertex_id[DX_TILE_MAX_VERTICES];
    float normal[3 * DX_TILE_MAX_VERTICES];
};

/* A session without a socket: options checked and copied. Errors: -EINVAL, -ENOMEM; on -EINVAL *out
 * is there all the same, for its error text. */
int dx_session_new(struct dexel **out, const struct dexel_options *options,
                   const struct dexel_callbacks *callbacks, void *user);
void dx_session_free(struct dexel *d);

/* Without a socket again, and without an error; the text of the last one stays. Errors: -ENOMEM. */
int dx_session_restart(struct dexel *d);

/* Queues HELLO and SUBSCRIBE. */
int dx_session_hello(struct dexel *d);

/* Sends what waits, handles what was received, reads once, handles that. 0, a callback's value, or
 * an error. */
int dx_session_turn(struct dexel *d);

/* Sets the sticky error; the text is in d->err already. Returns it. -ECONNRESET is the one that
 * another connection may mend. */
int dx_session_fail(struct dexel *d, int error);

/* Handles the whole messages that were received. 0, a callback's value, or an error. */
int dx_session_dispatch(struct dexel *d);

/* rebuild.c: the geometry of a q16 or delta stream, and tiles as the callbacks see them. Errors end
 * the session: -EPROTO (text set), -ENOMEM. */
int dx_session_begin_geometry(struct dexel *d);
int dx_session_add_geometry(struct dexel *d, const struct dx_msg_geometry *piece);
int dx_session_tile(struct dexel *d, const uint8_t *body, size_t len);

#endif
