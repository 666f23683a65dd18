/*
 * The noise model in integers (docs/terrain.md): one standard deviation at a range, in 1/256 of a
 * unit. Gates and estimator ask the same function, so that no rule depends on how a double is
 * rounded. Constant after init; any thread.
 */
#ifndef DX_SIGMA_H
#define DX_SIGMA_H

#include "core/rows/rows.h"

#include <stdint.h>

#define DX_SIGMA_MAX ((1u << 27) - 1) /* 2^19 units; leaves room for a factor of 32 in 32 bits */

/* sigma8(r) = min(DX_SIGMA_MAX, a0 + (r a1 >> 16) + ((r r >> 16) a2 >> 16)) */
struct dx_sigma {
    uint64_t a0, a1, a2;
    uint32_t full; /* sigma8 is the same from this range on; up to it 64 bits hold every product */
};

/* From s0 (m), s1 (1), s2 (1/m), none negative, and the unit of ranges; s0 is at least half a unit:
 * ranges are rounded. */
void dx_sigma_init(struct dx_sigma *s, const double sigma[3], double unit_m);

/* The same for loops over rows. */
struct dx_row_sigma dx_sigma_rows(const struct dx_sigma *s);

static inline uint32_t dx_sigma_at(const struct dx_sigma *s, uint32_t range)
{
    uint64_t r = range < s->full ? range : s->full;
    uint64_t v = s->a0 + (r * s->a1 >> 16) + ((r * r >> 16) * s->a2 >> 16);

    return v < DX_SIGMA_MAX ? (uint32_t)v : DX_SIGMA_MAX;
}

#endif
