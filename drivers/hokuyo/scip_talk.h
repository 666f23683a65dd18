/*
 * A link to a scanner and the session on it, joined: bytes go both ways until a scan is whole. The
 * reader's thread owns it; wake() is for any, also while one link is exchanged for another.
 */
#ifndef DX_SCIP_TALK_H
#define DX_SCIP_TALK_H

#include "drivers/hokuyo/scip_link.h"
#include "drivers/hokuyo/scip_session.h"

#include <pthread.h>

#define DX_SCIP_READ_MS 100 /* that one wait of the driver's takes at most */

struct dx_scip_talk {
    struct dx_scip_session session;
    uint8_t in[4096]; /* bytes [in_at, in_len) wait for the session */
    size_t in_at, in_len;
    uint64_t in_ns; /* when they came */

    pthread_mutex_t mutex;
    struct dx_scip_link *link; /* NULL: none yet; written under the mutex, by the owner */
    bool is_woken;             /* while there was none; under the mutex */
};

void dx_scip_talk_init(struct dx_scip_talk *t);
void dx_scip_talk_fini(struct dx_scip_talk *t); /* closes the link */

/* Takes the link (NULL: none); the one before is closed. */
void dx_scip_talk_set_link(struct dx_scip_talk *t, struct dx_scip_link *link);
/* Any thread: ends a wait now, or the next. */
void dx_scip_talk_wake(struct dx_scip_talk *t);
/* Was it woken while there was no link to end a wait of? Once. */
bool dx_scip_talk_take_wake(struct dx_scip_talk *t);

/* A talk from its beginning; the counts go on. `headroom`: bytes left free before a scan's.
 * -ENOMEM.
 */
int dx_scip_talk_begin(struct dx_scip_talk *t, const struct dx_scip_want *want, size_t headroom,
                       struct dx_err *err);
/* Feeds what waits to the session: 0 when a scan has become whole, or AGAIN: nothing is left. */
int dx_scip_talk_feed(struct dx_scip_talk *t);
/* Does what is due and waits for bytes once, until `until_ns` at most. 0: some came. AGAIN; GONE,
 * or negative: the scanner answers no more, or the link has failed. */
int dx_scip_talk_step(struct dx_scip_talk *t, uint64_t until_ns, struct dx_err *err);

#endif
