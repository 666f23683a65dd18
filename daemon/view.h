/*
 * A view: one subscriber's place in a feed. It knows which tiles are dirty for it and holds at most
 * one batch, the pinned chunks of one epoch, until they are sent. There is no queue: what changes
 * during a batch is dirty for the next. Loop thread.
 */
#ifndef DX_VIEW_H
#define DX_VIEW_H

#include "daemon/feed_loop.h"

struct dx_view_entry {
    uint32_t tile;
    uint32_t chunk; /* NONE: the tile is empty, or its chunk was released */
};

/* Region of tiles; no rows: all. */
struct dx_view_region {
    uint32_t row0, col0, rows, cols;
};

struct dx_view {
    struct dx_feed_loop *loop;
    struct dx_view *next, *prev;
    unsigned form;
    struct dx_view_region region;
    bool lossless;
    bool snapshot;     /* the next batch brings all tiles */
    bool late;         /* its last batch outlived the epoch: it waits for a free pin */
    uint64_t done_seq; /* of the last batch that was ended, 0 = none */
    uint64_t done_epoch;
    uint64_t *dirty; /* bit per tile */

    /* the batch */
    bool in_batch, batch_is_snapshot;
    uint64_t batch_seq, batch_epoch;
    struct dx_msg_commit commit; /* with n_tiles of this batch */
    uint64_t published_ns;       /* passage.h; 0: not known */
    struct dx_view_entry *entry;
    uint32_t n_entries;
    uint32_t n_held; /* entries whose chunk is not released */

    /*
     * The view loses its place: a RESET of the stream (`slow` false) or its pin was taken back
     * (true). Called while it still holds its chunks; they go right after. Must neither leave nor
     * begin.
     */
    void (*dropped)(struct dx_view *v, bool slow);
};

/* On a zeroed view with loop, form, region, lossless and dropped filled in. Errors: -ENOMEM. */
int dx_view_join(struct dx_view *v);
/* The bytes that this allocates. */
size_t dx_view_len(const struct dx_feed_loop *l);
void dx_view_leave(struct dx_view *v, uint64_t now_ns); /* nothing when it has not joined */

/* There is an epoch for it, whole in its form, that it has not had. */
bool dx_view_ready(const struct dx_view *v);

/*
 * Starts a batch of the newest epoch; the view is ready. False: it was late before, and all pins
 * are in use; try again when one is free, at the latest at dx_view_patience().
 */
bool dx_view_begin(struct dx_view *v, uint64_t now_ns);
uint64_t dx_view_patience(const struct dx_view *v);

/* Entry k has been sent. */
void dx_view_release(struct dx_view *v, uint32_t k);

/* The whole batch, its COMMIT too, has been sent. */
void dx_view_end(struct dx_view *v);

/* Gives the batch up: the next one is a snapshot. */
void dx_view_drop(struct dx_view *v);

#endif
