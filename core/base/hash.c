/* Content hash: 64-bit words multiplied and folded in four lanes, then mixed. */
#include "core/base/hash.h"

#include "core/base/bytes.h"

static const uint64_t prime[4] = {0x9e3779b185ebca87u, 0xc2b2ae3d27d4eb4fu, 0x165667b19e3779f9u,
                                  0x85ebca77c2b2ae63u};

static inline uint64_t fold(uint64_t lane, uint64_t v, uint64_t p)
{
    uint64_t x = (lane ^ v) * p;

    return x ^ (x >> 29);
}

uint64_t dx_hash(uint64_t seed, const void *bytes, size_t len)
{
    const uint8_t *p = bytes;
    uint64_t lane[4], tail = 0;
    size_t left = len;

    for (int k = 0; k < 4; k++)
        lane[k] = seed + prime[k];
    for (; left >= 32; left -= 32, p += 32)
        for (int k = 0; k < 4; k++)
            lane[k] = fold(lane[k], dx_get_u64(p + 8 * k), prime[k]);
    for (; left >= 8; left -= 8, p += 8)
        lane[0] = fold(lane[0], dx_get_u64(p), prime[0]);
    for (size_t k = 0; k < left; k++)
        tail |= (uint64_t)p[k] << (8 * k);
    lane[1] = fold(lane[1], tail, prime[1]);

    uint64_t h = dx_hash_u64(seed, len);
    for (int k = 0; k < 4; k++)
        h = dx_hash_u64(h, lane[k]);
    return h;
}
