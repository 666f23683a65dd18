/* Counts by bins; where strays are left out, once more within what remains, since with very far
 * ones all the others are in one bin. */
#include "core/cloud/bulk.h"

#include "core/cloud/dexels.h"

#include <stdbool.h>

#define N_BINS  1024
#define STRAYS  1024 /* one point of so many, at each end */
#define FEW     128  /* points, of which none is a stray */
#define MOST_BY 3    /* 2^28 steps by 2^10 bins */

static struct dx_bulk bounds(const int32_t (*at)[3], const uint32_t *dexel, uint32_t n, int axis)
{
    struct dx_bulk b = {INT32_MAX, 0};

    for (uint32_t k = 0; k < n; k++) {
        const int32_t x = at[k][axis];

        if (dexel[k] == DX_DEXEL_NONE)
            continue;
        b.low = x < b.low ? x : b.low;
        b.high = x > b.high ? x : b.high;
    }
    return b;
}

/* The part of the range that holds all but `strays` points at each end. */
static struct dx_bulk narrow(struct dx_bulk b, const int32_t (*at)[3], const uint32_t *dexel,
                             uint32_t n, int axis, uint32_t strays)
{
    const int32_t width = (b.high - b.low) / N_BINS + 1;
    uint32_t count[N_BINS] = {0}, below = 0, above = 0, first = 0, last = N_BINS - 1;

    for (uint32_t k = 0; k < n; k++) {
        const int32_t x = at[k][axis];

        if (dexel[k] == DX_DEXEL_NONE)
            continue;
        if (x < b.low)
            below++;
        else if (x > b.high)
            above++;
        else
            count[(x - b.low) / width]++;
    }
    while (first < last && below + count[first] <= strays)
        below += count[first++];
    while (last > first && above + count[last] <= strays)
        above += count[last--];
    return (struct dx_bulk){b.low + (int32_t)first * width,
                            last == N_BINS - 1 ? b.high : b.low + (int32_t)(last + 1) * width - 1};
}

struct dx_bulk dx_bulk_find(const int32_t (*at)[3], const uint32_t *dexel, uint32_t n, int axis)
{
    struct dx_bulk b = bounds(at, dexel, n, axis);

    for (int by = 0; n >= FEW && by < MOST_BY && b.low < b.high; by++) {
        const struct dx_bulk part = narrow(b, at, dexel, n, axis, n / STRAYS + 1);

        if (part.high - part.low > (b.high - b.low) / 2)
            break;
        b = part;
    }
    return b;
}
