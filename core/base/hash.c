/* Content hash: 64-bit words multiplied and folded in eight lanes, then mixed. */
#include "core/base/hash.h"

#include "core/base/bytes.h"

#define LANES 8 /* enough that none waits for its own product */

static const uint64_t prime[LANES] = {0x9e3779b185ebca87u, 0xc2b2ae3d27d4eb4fu, 0x165667b19e3779f9u,
                                      0x85ebca77c2b2ae63u, 0x27d4eb2f165667c5u, 0xff51afd7ed558ccdu,
                                      0xc4ceb9fe1a85ec53u, 0xd6e8feb86659fd93u};

static inline uint64_t fold(uint64_t lane, uint64_t v, uint64_t p)
{
    uint64_t x = (lane ^ v) * p;

    return x ^ (x >> 29);
}

uint64_t dx_hash(uint64_t seed, const void *bytes, size_t len)
{
    const uint8_t *p = bytes;
    uint64_t lane[LANES], tail = 0, h;
    size_t left = len;

    for (int k = 0; k < LANES; k++)
        lane[k] = seed + prime[k];
    for (; left >= 8 * LANES; left -= 8 * LANES, p += 8 * LANES)
        for (int k = 0; k < LANES; k++)
            lane[k] = fold(lane[k], dx_get_u64(p + 8 * k), prime[k]);
    for (; left >= 8; left -= 8, p += 8)
        lane[0] = fold(lane[0], dx_get_u64(p), prime[0]);
    for (size_t k = 0; k < left; k++)
        tail |= (uint64_t)p[k] << (8 * k);
    lane[1] = fold(lane[1], tail, prime[1]);

    h = dx_hash_u64(seed, len);
    for (int k = 0; k < LANES; k++)
        h = dx_hash_u64(h, lane[k]);
    return h;
}
