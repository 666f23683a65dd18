/*
 * What a stream's threads count, for status. Each counter has one writer (named here); the loop
 * reads. All relaxed: a counter orders nothing, and a status may be a moment old.
 */
#ifndef DX_COUNTERS_H
#define DX_COUNTERS_H

#include <stdatomic.h>
#include <stdint.h>

struct dx_counters {
    /* reader */
    _Atomic uint64_t n_corrupt; /* blocks that could not be decoded */

    /* mesher */
    _Atomic uint64_t n_parts;           /* taken from the mailbox */
    _Atomic uint64_t n_frames;          /* of them, that completed a frame */
    _Atomic uint64_t n_epochs;          /* published */
    _Atomic uint64_t n_short_of_chunks; /* epochs that had to be tried again */
    _Atomic uint64_t n_tiles_changed;
    _Atomic uint64_t n_tiles_same; /* of the same commits: not published, for nothing changed */
    _Atomic uint64_t mesh_ns;      /* spent computing tiles, in all */
    _Atomic uint64_t mesh_ns_last; /* the same, last commit */
    _Atomic uint64_t n_valid;      /* dexels with a range, last commit; 0: not known */

    /* loop */
    _Atomic uint64_t n_tiles_sent; /* TILE messages, all subscribers */
    _Atomic uint64_t n_slow;       /* times that a subscriber lost its place, being too slow */
};

static inline void dx_count(_Atomic uint64_t *counter, uint64_t n)
{
    /* one writer: a load and a store, no locked instruction */
    atomic_store_explicit(counter, atomic_load_explicit(counter, memory_order_relaxed) + n,
                          memory_order_relaxed);
}

static inline void dx_set(_Atomic uint64_t *counter, uint64_t value)
{
    atomic_store_explicit(counter, value, memory_order_relaxed);
}

static inline uint64_t dx_get(const _Atomic uint64_t *counter)
{
    return atomic_load_explicit(counter, memory_order_relaxed);
}

#endif
