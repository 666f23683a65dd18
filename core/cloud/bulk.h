/* Where most points of a cloud are along an axis: a few strays, which may be far, do not count. */
#ifndef DX_BULK_H
#define DX_BULK_H

#include <stdint.h>

struct dx_bulk {
    int32_t low, high; /* inclusive */
};

/* Of the coordinates at[k][axis], 0 or more, of the n points whose dexel is not DX_DEXEL_NONE; does
 * not depend on their order. All of them, where leaving strays out would not halve the range. */
struct dx_bulk dx_bulk_find(const int32_t (*at)[3], const uint32_t *dexel, uint32_t n, int axis);

#endif
