/* Loops of boundary edges: the rims of holes, traced from ring to ring with the hole to the left.
 */
#include "core/cloud/delaunay_priv.h"

#define NONE UINT32_MAX

/* The hole is to the left of edge u-v; where its rim goes on from v: of the last ends of v's
 * chains, the one before u. NONE: u-v has no hole to its left. */
static uint32_t next_on_rim(const struct dx_delaunay_run *run, uint32_t u, uint32_t v)
{
    const uint32_t ring = run->ring[v] == DX_RING_WHOLE ? 0 : run->ring[v];
    const uint32_t n = dx_ring_n(&run->rings, ring), *list = dx_ring_list(&run->rings, ring);
    struct dx_tangent t;
    struct dx_flat at_u, at_best = {0, 0};
    uint32_t best = NONE;
    bool found = false;

    if (n == 0 || !dx_tangent_of(&t, run, v) || !dx_tangent_flat(&at_u, &t, run->cloud->at[u]))
        return NONE;
    for (uint32_t k = 0; k < n; k++) {
        const uint32_t last = list[k] & ~DX_RING_FIRST;
        struct dx_flat at;

        found |= list[k] == (u | DX_RING_FIRST);
        if (k + 1 < n && !(list[k + 1] & DX_RING_FIRST))
            continue;
        if (!dx_tangent_flat(&at, &t, run->cloud->at[last]))
            return NONE;
        if (best == NONE || dx_flat_in_sector(at_best, at_u, at)) {
            best = last;
            at_best = at;
        }
    }
    return found ? best : NONE;
}

uint32_t dx_delaunay_trace(uint32_t *rim, const struct dx_delaunay_run *run, uint32_t a, uint32_t b)
{
    uint32_t n = 0, u = a, v = b;

    do {
        uint32_t w;

        if (n == run->config->max_loop || v < a) /* of a lower point's */
            return 0;
        rim[n++] = v;
        w = next_on_rim(run, u, v);
        if (w == NONE)
            return 0;
        u = v;
        v = w;
    } while (u != a || v != b);
    return n;
}
