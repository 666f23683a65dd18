/*
 * The heartbeat of a thread: one word, written by the thread and read by the loop, that says until
 * when all is well with it. A thread beats before each step of its work; a step that may take
 * longer than usual says by how much; a thread that goes into a wait that may last for ever rests.
 * So only one that is stuck in the middle of its work is ever late. What "usual" is the loop knows
 * (watchdog.h).
 */
#ifndef DX_HEARTBEAT_H
#define DX_HEARTBEAT_H

#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>

/* Relaxed: nothing else hangs on it. */
struct dx_heartbeat {
    _Atomic uint64_t well_until_ns; /* of dx_clock_ns(); 0: it rests, or does not run */
};

/* The threads of a stream that are watched. */
enum dx_beating {
    DX_BEAT_READER,
    DX_BEAT_MESHER,
    DX_BEAT_RECORDER,
    DX_N_BEATS,
};

struct dx_heartbeats {
    struct dx_heartbeat of[DX_N_BEATS];
};

/* What a lawful step takes at the very most, on the slowest machine. */
#define DX_HEARTBEAT_DEXEL_NS 2000u /* to decode or to mesh a dexel */
#define DX_HEARTBEAT_BYTE_NS  1000u /* to decode a byte */

/* ---- the thread; NULL: nobody watches it ------------------------------------------------------
 */

/* The next step may take `more_ns` longer than usual. */
static inline void dx_heartbeat_allow(struct dx_heartbeat *h, uint64_t now_ns, uint64_t more_ns)
{
    if (h)
        atomic_store_explicit(&h->well_until_ns, now_ns + more_ns, memory_order_relaxed);
}

static inline void dx_heartbeat_beat(struct dx_heartbeat *h, uint64_t now_ns)
{
    dx_heartbeat_allow(h, now_ns, 0);
}

/* It waits for what may never come (mail, a subscriber, another watched thread), or ends. */
static inline void dx_heartbeat_rest(struct dx_heartbeat *h)
{
    if (h)
        atomic_store_explicit(&h->well_until_ns, 0, memory_order_relaxed);
}

/* ---- the loop --------------------------------------------------------------------------------
 */

/* For how long it has given no sign beyond what its step may take; 0: all is well. */
static inline uint64_t dx_heartbeat_late_ns(const struct dx_heartbeat *h, uint64_t now_ns)
{
    uint64_t until = atomic_load_explicit(&h->well_until_ns, memory_order_relaxed);

    return until && now_ns > until ? now_ns - until : 0;
}

#endif
