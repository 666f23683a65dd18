/* Chunk bodies for the feed's tests: any length, bytes that follow from a version number alone. */
#ifndef FEED_BODY_H
#define FEED_BODY_H

#include "core/base/hash.h"
#include "daemon/feed.h"
#include "daemon/feed_loop.h"

#define FEED_BODY_MAX (3 * DX_FEED_BLOCK_LEN + 512)

/* Version 0 is the empty tile. Mostly short, sometimes four blocks. */
static inline size_t feed_body_len(uint64_t version)
{
    uint64_t h = dx_hash_u64(1, version);

    if (version == 0)
        return DX_CHUNK_HEADER_LEN;
    return DX_CHUNK_HEADER_LEN + 1 + h % (h >> 60 == 0 ? FEED_BODY_MAX - 16 : 100);
}

static inline size_t feed_body_make(uint8_t *body, uint64_t version)
{
    size_t len = feed_body_len(version);

    for (size_t k = 0; k < len; k += 8) {
        uint64_t word = dx_hash_u64(version, k);

        memcpy(body + k, &word, len - k < 8 ? len - k : 8);
    }
    return len;
}

/* The chunk in the arena has exactly the bytes of the version. */
static inline bool feed_body_is(const struct dx_feed *f, uint32_t number, uint64_t version)
{
    const struct dx_feed_chunk *c = &f->chunk[number];
    uint8_t body[FEED_BODY_MAX];
    uint32_t block = c->first;
    size_t len = feed_body_make(body, version);

    if (c->len != len)
        return false;
    for (size_t at = 0; at < len; at += DX_FEED_BLOCK_LEN) {
        size_t n = len - at < DX_FEED_BLOCK_LEN ? len - at : DX_FEED_BLOCK_LEN;

        if (memcmp(dx_feed_block(f, block), body + at, n))
            return false;
        block = f->next_block[block];
    }
    return true;
}

/* A chunk of a tile to the open epoch. False: short of chunks. */
static inline bool feed_add_body(struct dx_feed *f, uint32_t tile, unsigned form,
                                 const uint8_t *body, size_t len)
{
    uint32_t chunk;

    if (!dx_feed_add(f, tile, form, len, &chunk))
        return false;
    dx_feed_fill(f, chunk, body);
    return true;
}

#endif
