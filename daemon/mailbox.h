/*
 * The mailbox between a stream's reader and its mesher: three frames, whose columns arrive in
 * parts.
 *
 * The reader fills a frame's plane and delivers columns of it; the mesher takes the columns that
 * are new, reading the plane in place while the reader goes on with other columns of it: different
 * dexels, so nothing is copied and nothing of a slow scan is skipped. When the reader starts a
 * frame and none of the three is free, live the oldest waiting frame is overwritten (and counted),
 * lossless the reader waits. Geometry changes and states keep their place in the order.
 *
 * One lock, held for a few instructions, shared by these two threads only: no client can hold it.
 */
#ifndef DX_MAILBOX_H
#define DX_MAILBOX_H

#include "core/wire/wire.h"
#include "drivers/driver.h"

struct dx_mailbox;

/* `wake` is called (by the reader, without the lock) when there is something to take. Errors:
 * -ENOMEM. */
int dx_mailbox_new(struct dx_mailbox **out, bool lossless, void (*wake)(void *ctx), void *ctx);
void dx_mailbox_free(struct dx_mailbox *m);

/* Nobody waits any more: plane() gives NULL, geometry() -ECANCELED. Any thread. */
void dx_mailbox_close(struct dx_mailbox *m);

/* ---- the reader's half; plugs into a driver as its sink -------------------------------------- */

struct dx_frame_sink dx_mailbox_sink(struct dx_mailbox *m);
void dx_mailbox_put_state(struct dx_mailbox *m, enum dx_stream_state state, const char *reason);

/* ---- the mesher's half ----------------------------------------------------------------------- */

enum dx_mail {
    DX_MAIL_NONE,
    DX_MAIL_GEOMETRY, /* the frames from here on have this geometry */
    DX_MAIL_COLUMNS,  /* columns of a frame */
    DX_MAIL_STATE,
};

struct dx_mail_item {
    enum dx_mail kind;
    struct dx_geometry *geometry; /* GEOMETRY: a reference that is now the taker's */
    uint8_t attr_bytes;
    const struct dx_plane *plane; /* COLUMNS: until dx_mailbox_release */
    const uint64_t *columns;      /* bit per column: new since the last take */
    uint64_t frame;
    bool complete;              /* no more columns of this frame will come */
    struct dx_stamp stamp;      /* of its newest part */
    uint64_t delivered_ns;      /* when that part was */
    enum dx_stream_state state; /* STATE */
    char reason[DX_WIRE_TEXT];
};

/* Never waits. The next item in order; live, a frame that a later complete one makes stale is
 * skipped. */
enum dx_mail dx_mailbox_take(struct dx_mailbox *m, struct dx_mail_item *item);

/* Gives the taken columns back; at most one COLUMNS item is out at a time. */
void dx_mailbox_release(struct dx_mailbox *m);

/* Frames that were overwritten or skipped. Any thread. */
uint64_t dx_mailbox_n_skipped(struct dx_mailbox *m);

#endif
