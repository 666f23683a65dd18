/*
 * Raw blocks on their way from a reader to its recorder: a ring of bytes between one producer and
 * one consumer, allocated once. A block is put whole (in pieces, recording.h) or not at all, so the
 * producer never waits. Entries lie in one run of bytes each.
 */
#ifndef DX_BLOCK_RING_H
#define DX_BLOCK_RING_H

#include "drivers/driver.h"
#include "drivers/file/recording.h"

#include <stdalign.h>
#include <stdatomic.h>

enum dx_ring_kind {
    DX_RING_PIECE = 1, /* bytes: a message of the recording */
    DX_RING_GAP,       /* dx_ring_gap */
    DX_RING_GEOMETRY,  /* dx_ring_geometry; the taker gets the reference */
};

/* Blocks that were not put. */
struct dx_ring_gap {
    uint64_t n, first, from_ns, to_ns; /* first: number of the first one; host stamps */
};

struct dx_ring_geometry {
    struct dx_geometry *geometry;
    uint8_t attr_bytes;
    uint64_t host_ns; /* when it was told */
};

struct dx_ring_entry {
    enum dx_ring_kind kind;
    bool starts_block; /* of pieces */
    bool starts_frame;
    uint64_t host_ns;
    const uint8_t *bytes;
    size_t len;
};

struct dx_block_ring {
    uint8_t *bytes;
    size_t cap;                        /* a power of two */
    struct dx_ring_gap gap;            /* the producer's: what has been lost since the last put */
    struct dx_ring_geometry waits;     /* the producer's: told, and there was no room yet */
    alignas(64) _Atomic uint64_t head; /* the consumer's; both only grow */
    alignas(64) _Atomic uint64_t tail; /* the producer's */
};

/* `cap` is rounded up to a power of two. -ENOMEM. */
int dx_block_ring_init(struct dx_block_ring *r, size_t cap);
void dx_block_ring_fini(struct dx_block_ring *r); /* drops what is left in it */

/* Makes its memory be there, which else is made page by page as the producer comes to it. Beside
 * producer and consumer; where the kernel cannot, nothing. */
void dx_block_ring_populate(struct dx_block_ring *r);

/* ---- producer --------------------------------------------------------------------------------
 */

/* False: no room; the block is counted in the gap, which is put before the next that fits. */
bool dx_block_ring_put(struct dx_block_ring *r, const struct dx_block *block, bool starts_frame);
/* Takes its own reference. */
void dx_block_ring_put_geometry(struct dx_block_ring *r, const struct dx_ring_geometry *told);

/* ---- consumer --------------------------------------------------------------------------------
 */

/* The oldest entry, whose bytes hold until pop(). False: empty. */
bool dx_block_ring_peek(struct dx_block_ring *r, struct dx_ring_entry *out);
void dx_block_ring_pop(struct dx_block_ring *r);
/* Bytes in it, for status; any thread. */
size_t dx_block_ring_used(const struct dx_block_ring *r);

#endif
