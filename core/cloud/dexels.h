/* Points into dexels, sorted by depth: a part of loading a cloud. */
#ifndef DX_DEXELS_H
#define DX_DEXELS_H

#include "core/cloud/cloud.h"

#define DX_DEXEL_NONE UINT32_MAX

/* The input on the lattice, in its own order. */
struct dx_dexel_input {
    uint32_t n;
    int32_t (*at)[3];
    uint32_t *dexel; /* row * cols + column, DX_DEXEL_NONE: no point */
};

/* rows, cols, side and low for c->n points: some points a dexel, so that a box of neighbours covers
 * few dexels, in each of which its depths are found by halving. */
void dx_dexels_size(struct dx_cloud *c, const struct dx_dexel_input *in);

/* The row of coordinate 0, or the column of coordinate 1. */
static inline uint32_t dx_dexel_place(const struct dx_cloud *c, int coordinate, int64_t x)
{
    const uint32_t n = coordinate == 0 ? c->rows : c->cols;
    const int64_t k = x > c->low[coordinate] ? (x - c->low[coordinate]) / c->side : 0;

    return k < n ? (uint32_t)k : n - 1;
}

/* at, index and start; takes out duplicates. Errors: -ENOMEM. */
int dx_dexels_fill(struct dx_cloud *c, const struct dx_dexel_input *in, struct dx_pool *pool);

#endif
