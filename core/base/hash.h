/*
 * A 64-bit content hash, not cryptographic: tells changed tiles from unchanged ones and stands for
 * a mesh in golden tests. The same value on every machine.
 */
#ifndef DX_HASH_H
#define DX_HASH_H

#include <stddef.h>
#include <stdint.h>

/* Hash of `len` bytes, continuing from `seed` (0 to start). */
uint64_t dx_hash(uint64_t seed, const void *bytes, size_t len);

/* One word mixed into `seed`; also the generator behind seeded noise (rng.h). */
static inline uint64_t dx_hash_u64(uint64_t seed, uint64_t v)
{
    uint64_t x = (seed ^ v) + 0x9e3779b97f4a7c15u;

    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

#endif
