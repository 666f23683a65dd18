/*
 * The byte side of a connection: the socket, what waits to go out, and what came in, cut into
 * messages. Belongs to the thread that drives the connection.
 */
#ifndef DX_CONNECTION_H
#define DX_CONNECTION_H

#include "core/base/err.h"
#include "core/wire/wire.h"

#define DX_CONNECTION_OUT 1024 /* room for what a client says: HELLO, SUBSCRIBE and some NEXT */

enum {
    DX_CONNECTION_MESSAGE = 1, /* dx_connection_next: there is a whole message */
    DX_CONNECTION_BYTES = 1,   /* dx_connection_fill: something came */
};

struct dx_connection {
    int fd;
    uint8_t *in; /* unread: [in_pos, in_len) */
    size_t in_cap, in_pos, in_len;
    uint32_t max_body; /* of the server; small until WELCOME tells it */
    uint32_t seq_in, seq_out;
    uint8_t out[DX_CONNECTION_OUT];
    size_t out_len;
};

/* A connection without a socket (fd -1). Errors: -ENOMEM. */
int dx_connection_init(struct dx_connection *c);
void dx_connection_fini(struct dx_connection *c);

/* Whether to wait, 10 s at most, while the backlog of the server is full. */
enum dx_connection_wait { DX_CONNECTION_WAIT, DX_CONNECTION_TRY };

/* Connects and makes the socket non-blocking. Errors: -ENAMETOOLONG, those of socket(2) and
 * connect(2). */
int dx_connection_open(struct dx_connection *c, const char *path, enum dx_connection_wait wait,
                       struct dx_err *err);

/* From WELCOME on: longer bodies are refused. Moves the unread bytes. Errors: -ENOMEM. */
int dx_connection_set_max_body(struct dx_connection *c, uint32_t max_body);

/* Queues a message and sends what the socket takes. A peer that is gone is no error here: what it
 * still said is to be read first. Errors: -ENOBUFS (nothing queued), those of send(2). */
int dx_connection_send(struct dx_connection *c, enum dx_message type, const uint8_t *body,
                       size_t len);
int dx_connection_flush(struct dx_connection *c);

/* Receives once into the free part of the buffer. DX_CONNECTION_BYTES; 0 when nothing is there;
 * -ECONNRESET at the end of the stream. Call when dx_connection_next has no message: then there is
 * room. */
int dx_connection_fill(struct dx_connection *c, struct dx_err *err);

/* Cuts the next message off: DX_CONNECTION_MESSAGE (`body` holds until the next call), 0 when it is
 * not whole yet, -EPROTO for a body too long or a sequence number out of order. */
int dx_connection_next(struct dx_connection *c, struct dx_wire_header *h, const uint8_t **body,
                       struct dx_err *err);

#endif
