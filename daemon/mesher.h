/*
 * The mesher of one stream: takes columns from the mailbox, publishes them to the dexel array,
 * commits the mesh, encodes what somebody wants and hands it to the feed. One thread; tiles go over
 * the shared pool. It never touches a socket and never waits for a client (save between frames of a
 * lossless replay).
 */
#ifndef DX_MESHER_H
#define DX_MESHER_H

#include "core/grid/terrain.h"
#include "daemon/counters.h"
#include "daemon/feed.h"
#include "daemon/heartbeat.h"
#include "daemon/mailbox.h"

struct dx_mesher_config {
    const char *name;
    struct dx_terrain_params terrain;
    uint32_t commit_ms; /* parts of an unfinished frame are committed at most this often */
    bool lossless;
    uint32_t max_tiles;        /* the feed's; a larger grid is refused */
    struct dx_heartbeat *beat; /* NULL: nobody watches */
};

struct dx_mesher;

/* Borrows everything but the config. Errors: -ENOMEM. */
int dx_mesher_new(struct dx_mesher **out, const struct dx_mesher_config *config,
                  struct dx_mailbox *mailbox, struct dx_feed *feed, struct dx_counters *counters,
                  struct dx_pool *pool);
void dx_mesher_free(struct dx_mesher *m);

/* Something may have changed: mail, encodings wanted, chunks home. Any thread; never blocks. */
void dx_mesher_kick(void *mesher);

/* The thread's body: runs until dx_mesher_stop. */
void dx_mesher_run(struct dx_mesher *m);
void dx_mesher_stop(struct dx_mesher *m); /* any thread */

#endif
