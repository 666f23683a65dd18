/* Mixed pixels by the votes of a sample's row and column. */
#include "core/grid/mixed.h"

#include <string.h>

#define FEW_NEIGHBOURS 3 /* strict: joined to at most so many of eight */

static void strict_row(struct dx_area *a, uint32_t p)
{
    for (uint32_t q = 1; q < DX_AREA; q++) {
        int n = a->joined[DX_EDGE_H][p][q - 1] + a->joined[DX_EDGE_H][p][q] +
                a->joined[DX_EDGE_V][p - 1][q] + a->joined[DX_EDGE_V][p][q] +
                a->joined[DX_EDGE_AC][p - 1][q - 1] + a->joined[DX_EDGE_AC][p][q] +
                a->joined[DX_EDGE_BD][p - 1][q] + a->joined[DX_EDGE_BD][p][q - 1];

        a->alive[p][q] &= n > FEW_NEIGHBOURS;
    }
}

/* Rows from the first that is read to the last have joined edges on both sides only inside; outside
 * of it the area ends, and no outcome of the tile asks. */
void dx_mixed_find(struct dx_area *a, const struct dx_gates *gates)
{
    for (uint32_t p = a->first; p < a->end; p++) {
        if (gates->mixed == DX_MIXED_OFF || p == a->first || p + 1 == a->end) {
            memcpy(a->alive[p], a->valid[p], sizeof(a->alive[p]));
            continue;
        }
        gates->rows->vote(a->alive[p], a->joined[DX_EDGE_H][p], a->joined[DX_EDGE_V][p],
                          a->joined[DX_EDGE_V][p - 1],
                          (const uint8_t *const[]){a->valid[p - 1], a->valid[p], a->valid[p + 1]});
        if (gates->mixed == DX_MIXED_STRICT)
            strict_row(a, p);
    }
}
