/* Mixed pixels by the votes of a sample's row and column. */
#include "core/grid/mixed.h"

#include <string.h>

#define FEW_NEIGHBOURS 3 /* strict: joined to at most so many of eight */

/* Rows from the first that is read to the last have joined edges on both sides only inside; outside
 * of it the area ends, and no outcome of the tile asks. */
static void axis_row(struct dx_area *a, uint32_t p)
{
    const uint32_t *here = a->range[p], *above = a->range[p - 1], *below = a->range[p + 1];
    const uint8_t *h = a->joined[DX_EDGE_H][p];
    const uint8_t *v = a->joined[DX_EDGE_V][p], *v_above = a->joined[DX_EDGE_V][p - 1];

    for (uint32_t q = 1; q < DX_AREA_N; q++) {
        uint8_t row = (here[q - 1] != 0) & (here[q + 1] != 0) & !(h[q - 1] | h[q]);
        uint8_t column = (above[q] != 0) & (below[q] != 0) & !(v_above[q] | v[q]);

        a->alive[p][q] &= !(row | column);
    }
}

static void strict_row(struct dx_area *a, uint32_t p)
{
    for (uint32_t q = 1; q < DX_AREA_N; q++) {
        int n = a->joined[DX_EDGE_H][p][q - 1] + a->joined[DX_EDGE_H][p][q] +
                a->joined[DX_EDGE_V][p - 1][q] + a->joined[DX_EDGE_V][p][q] +
                a->joined[DX_EDGE_AC][p - 1][q - 1] + a->joined[DX_EDGE_AC][p][q] +
                a->joined[DX_EDGE_BD][p - 1][q] + a->joined[DX_EDGE_BD][p][q - 1];

        a->alive[p][q] &= n > FEW_NEIGHBOURS;
    }
}

void dx_mixed_find(struct dx_area *a, const struct dx_gates *gates)
{
    for (uint32_t p = a->first; p < a->end; p++) {
        for (uint32_t q = 0; q < DX_AREA_STRIDE; q++)
            a->alive[p][q] = a->range[p][q] != 0;
        if (gates->mixed == DX_MIXED_OFF || p == a->first || p + 1 == a->end)
            continue;
        axis_row(a, p);
        if (gates->mixed == DX_MIXED_STRICT)
            strict_row(a, p);
    }
}
