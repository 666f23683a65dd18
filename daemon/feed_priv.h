/*
 * What both halves of a feed see: the arena, the rings between mesher and loop, and the few
 * atomics. Included by feed.c (mesher), feed_loop.c and view.c (loop), and their tests; by nobody
 * else.
 *
 * Ownership moves with the ring: a chunk or an event is the mesher's while it is free or in an
 * epoch not yet published, and the loop's from dx_ring_push(to_loop) until dx_ring_push(home).
 * Nobody touches what is the other's, so only the rings, `wanted`, `level`, `starved` and
 * `lossless_epoch` are atomic.
 */
#ifndef DX_FEED_PRIV_H
#define DX_FEED_PRIV_H

#include <stdatomic.h>

#include "daemon/feed.h"
#include "daemon/ring.h"

#define DX_FEED_BLOCK_LEN 4096u
#define DX_FEED_NONE      UINT32_MAX

struct dx_feed_chunk {
    uint32_t first, last; /* chain of blocks; NONE: the tile is empty */
    uint32_t n_blocks;
    uint32_t len; /* bytes of the body */
    uint32_t tile;
    uint32_t form;
    uint32_t generation; /* of the form, that this chunk answers */
    uint32_t next;       /* in a free list, or in the epoch it was published with */
    uint32_t refs;       /* the loop's */
    uint64_t epoch;
};

enum dx_feed_event_kind {
    DX_FEED_COMMIT,
    DX_FEED_RESET,
    DX_FEED_STATE,
};

struct dx_feed_event {
    enum dx_feed_event_kind kind;
    uint32_t next; /* in the free list */
    char reason[DX_WIRE_TEXT];
    /* commit */
    uint64_t epoch;
    uint32_t first_chunk; /* list of what the epoch brings */
    uint32_t generation[DX_N_FORMS];
    struct dx_msg_commit commit;
    struct dx_passage passage;
    /* reset: one reference on the geometry travels with the event */
    struct dx_geometry *geometry;
    struct dx_terrain_params params;
    uint8_t attr_bytes;
    /* state */
    enum dx_stream_state state;
};

/* Free things: last freed is first used again (warm), and what was never used is not touched. */
struct dx_feed_stack {
    uint32_t head, n_fresh, n;
};

/* Things to publish that are not in the ring yet; at most one of each, in this order. */
struct dx_feed_outbox {
    bool has_reset, has_epoch, has_state;
    struct dx_feed_event reset, epoch, state;
    uint32_t first, last; /* chunks of `epoch` and of the open epoch after it */
    uint32_t mark;        /* last chunk before the open epoch, or NONE */
    bool open;
    uint64_t open_epoch;
    uint32_t open_generation[DX_N_FORMS];
};

struct dx_feed {
    uint32_t max_tiles, n_chunks, n_events;
    uint32_t tile_blocks, n_epochs; /* blocks of a tile in all forms; 0: no quota */
    uint8_t *memory;                /* address space of all blocks */
    size_t memory_len;
    uint32_t *next_block;
    struct dx_feed_chunk *chunk;
    struct dx_feed_event *event;
    int wake_fd;
    bool own_wake_fd;
    void (*kick)(void *ctx);
    void *kick_ctx;

    struct dx_ring to_loop;               /* events */
    struct dx_ring home;                  /* chunks, and events as n_chunks + number */
    _Atomic uint32_t wanted[DX_N_FORMS];  /* loop writes */
    _Atomic uint32_t level[DX_LOD_SLOTS]; /* loop writes, while nobody wants it: packed */
    _Atomic uint64_t lossless_epoch;      /* loop writes */
    _Atomic bool starved;                 /* mesher sets, loop clears */

    /* the mesher's alone */
    struct dx_feed_stack free_blocks, free_chunks, free_events;
    uint32_t keep_blocks, keep_chunks; /* stay free: what the grid in force does not need */
    struct dx_feed_outbox out;
};

/* dx_feed_new with every size given (tests: shortage at will). `wake_fd` -1: the feed makes its
 * own. */
int dx_feed_new_sized(struct dx_feed **out, uint32_t max_tiles, uint32_t n_blocks,
                      uint32_t n_chunks, uint32_t n_events, int wake_fd, void (*kick)(void *ctx),
                      void *kick_ctx);

static inline uint32_t dx_feed_pack_level(struct dx_lod_level level)
{
    return (uint32_t)level.stride << 16 | level.bound;
}

static inline uint8_t *dx_feed_block(const struct dx_feed *f, uint32_t block)
{
    return f->memory + (size_t)block * DX_FEED_BLOCK_LEN;
}

#endif
