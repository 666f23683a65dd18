/*
 * Seeded random numbers, the same on every machine. A generator is one word; independent streams
 * come from hashing what they belong to (seed, frame, dexel) into the state, so that nothing
 * depends on the order in which dexels are drawn. One owner per generator.
 */
#ifndef DX_RNG_H
#define DX_RNG_H

#include "core/base/hash.h"

struct dx_rng {
    uint64_t state;
};

static inline struct dx_rng dx_rng_init(uint64_t seed, uint64_t stream)
{
    return (struct dx_rng){dx_hash_u64(dx_hash_u64(0, seed), stream)};
}

static inline uint64_t dx_rng_u64(struct dx_rng *g)
{
    g->state += 0x9e3779b97f4a7c15u;
    return dx_hash_u64(0, g->state);
}

/* Uniform in [0, n); n > 0. */
static inline uint32_t dx_rng_below(struct dx_rng *g, uint32_t n)
{
    return (uint32_t)(((dx_rng_u64(g) >> 32) * n) >> 32);
}

/* Uniform in [0, 1). */
static inline double dx_rng_unit(struct dx_rng *g)
{
    return (double)(dx_rng_u64(g) >> 11) * 0x1p-53;
}

/* Normal with mean 0 and variance 1, within 9 of 0; one draw. */
double dx_rng_normal(struct dx_rng *g);

#endif
