/*
 * What one subscriber is being sent at the moment: a window of whole messages. It is filled when
 * empty and written until empty; bodies of TILEs stay in the arena. Not a queue: what is not in the
 * window is state elsewhere (flags, dirty tiles), and is put into words when its turn comes. Loop
 * thread.
 */
#ifndef DX_OUTBOX_H
#define DX_OUTBOX_H

#include "daemon/feed_priv.h"

#define DX_OUTBOX_MESSAGES 64
#define DX_OUTBOX_HEADS    4096 /* headers of 64 TILEs, and one of each short message */

struct dx_out_message {
    uint16_t type;
    uint32_t head_at, head_len; /* in `heads`: header and what is not in the arena */
    uint32_t chunk;             /* body: bytes of this chunk from `skip`, or NONE */
    uint32_t skip, body_len;
    uint32_t entry; /* of the view's batch (TILE) */
    bool own;       /* body: in `own` */
};

struct dx_outbox {
    const struct dx_feed *feed; /* of `chunk`s */
    uint32_t seq;               /* of the next message to be put */
    uint32_t n, first;
    size_t sent; /* bytes of message `first` that are gone */
    uint32_t heads_len;
    uint8_t *own; /* a GEOMETRY piece, or what is left of a TILE whose pin was taken back */
    struct dx_out_message message[DX_OUTBOX_MESSAGES];
    uint8_t heads[DX_OUTBOX_HEADS];
};

/* Room of `own`: the longest body. */
#define DX_OUTBOX_OWN DX_WIRE_MAX_BODY

static inline bool dx_outbox_is_empty(const struct dx_outbox *o)
{
    return o->first == o->n;
}

/* Room for a message of any kind. */
static inline bool dx_outbox_has_room(const struct dx_outbox *o)
{
    return o->n < DX_OUTBOX_MESSAGES && o->heads_len + 1024 <= DX_OUTBOX_HEADS;
}

/* The body of a short message is written to what begin returns; end makes it a message. */
struct dx_writer dx_outbox_begin(struct dx_outbox *o);
struct dx_out_message *dx_outbox_end(struct dx_outbox *o, const struct dx_writer *w,
                                     enum dx_message type, uint32_t stream, uint64_t epoch,
                                     uint32_t body_len);

/*
 * Writes what it can, at most about `budget` bytes. Returns how many, 0 when the socket is full, or
 * -errno. `sent` is called for each message that has gone whole.
 */
ssize_t dx_outbox_write(struct dx_outbox *o, int fd, size_t budget,
                        void (*sent)(void *ctx, const struct dx_out_message *m), void *ctx);

/*
 * Drops what has not begun to go; WELCOME stays. A message that has begun is kept as a copy, so
 * that nothing refers to the arena any more. Returns the type of that message, or 0.
 */
uint16_t dx_outbox_cut(struct dx_outbox *o);

#endif
