/* Mixed pixels by the votes of a sample's row and column. */
#include "core/grid/mixed.h"

/* Valid samples of row p whose two neighbours in the row are there and not joined to them, or the
 * two in the column. */
static dx_bits cut_off(const struct dx_area *a, uint32_t p)
{
    const dx_bits here = a->valid[p], h = a->joined[DX_EDGE_H][p];
    const dx_bits v = a->joined[DX_EDGE_V][p - 1] | a->joined[DX_EDGE_V][p];
    const dx_bits in_row = here << 1 & here >> 1 & ~(h << 1 | h);
    const dx_bits in_column = a->valid[p - 1] & a->valid[p + 1] & ~v;

    return in_row | in_column;
}

/* Sums of one bit each, column by column: up to 3, and whether there were more. */
struct count {
    dx_bits ones, twos, more;
};

static void add(struct count *n, dx_bits row)
{
    const dx_bits carry = n->ones & row;

    n->ones ^= row;
    n->more |= n->twos & carry;
    n->twos ^= carry;
}

/* Samples of row p that are joined to more than three of eight neighbours: what strict asks for. */
static dx_bits well_joined(const struct dx_area *a, uint32_t p)
{
    struct count n = {0, 0, 0};

    add(&n, a->joined[DX_EDGE_H][p] << 1);
    add(&n, a->joined[DX_EDGE_H][p]);
    add(&n, a->joined[DX_EDGE_V][p - 1]);
    add(&n, a->joined[DX_EDGE_V][p]);
    add(&n, a->joined[DX_EDGE_AC][p - 1] << 1);
    add(&n, a->joined[DX_EDGE_AC][p]);
    add(&n, a->joined[DX_EDGE_BD][p - 1]);
    add(&n, a->joined[DX_EDGE_BD][p] << 1);
    return n.more;
}

/* Rows from the first that is read to the last have joined edges on both sides only inside; outside
 * of it the area ends, and no outcome of the tile asks. */
void dx_mixed_find(struct dx_area *a, const struct dx_gates *gates)
{
    for (uint32_t p = a->first; p < a->end; p++) {
        a->alive[p] = a->valid[p];
        if (gates->mixed == DX_MIXED_OFF || p == a->first || p + 1 == a->end)
            continue;
        a->alive[p] &= ~cut_off(a, p);
        if (gates->mixed == DX_MIXED_STRICT)
            a->alive[p] &= well_joined(a, p);
    }
    for (uint32_t p = a->first; p < a->end; p++) {
        dx_bits both[DX_N_EDGES];

        dx_edges_both(both, a->alive[p], p + 1 < a->end ? a->alive[p + 1] : 0);
        for (enum dx_edge e = 0; e < DX_N_EDGES; e++)
            a->edge[e][p] = a->joined[e][p] & both[e];
    }
}
