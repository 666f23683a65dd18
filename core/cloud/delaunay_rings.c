/*
 * Triangles that are not all corners' own: they go into the rings of points whose star is not
 * agreed on. A ring keeps the mesh a manifold; whether a triangle also lies beside the others and
 * not over them is looked at in the tangent plane of each corner.
 */
#include "core/cloud/delaunay_priv.h"

#include <errno.h>

static bool fits(const struct dx_delaunay_run *run, uint32_t v, uint32_t a, uint32_t b)
{
    return run->ring[v] != DX_RING_WHOLE && dx_ring_fits(&run->rings, run->ring[v], a, b);
}

bool dx_delaunay_fits(const struct dx_delaunay_run *run, uint32_t a, uint32_t b, uint32_t c)
{
    return fits(run, a, b, c) && fits(run, b, c, a) && fits(run, c, a, b);
}

/* In the plane of v, wedge a-b is less than half a turn and over none of those that are there. */
static bool is_clear(const struct dx_delaunay_run *run, uint32_t v, uint32_t a, uint32_t b)
{
    const uint32_t n = dx_ring_n(&run->rings, run->ring[v]);
    const uint32_t *list = dx_ring_list(&run->rings, run->ring[v]);
    struct dx_tangent t;
    struct dx_flat fa, fb, before = {0, 0};

    if (!dx_tangent_of(&t, run, v) || !dx_tangent_flat(&fa, &t, run->cloud->at[a]) ||
        !dx_tangent_flat(&fb, &t, run->cloud->at[b]) || dx_flat_cross(fa, fb) <= 0)
        return false;
    for (uint32_t k = 0; k < n; k++) {
        const uint32_t rank = list[k] & ~DX_RING_FIRST;
        struct dx_flat at;

        if (!dx_tangent_flat(&at, &t, run->cloud->at[rank]))
            return false;
        if (dx_flat_in_sector(fa, fb, at))
            return false;
        if (!(list[k] & DX_RING_FIRST) &&
            (dx_flat_in_sector(before, at, fa) || dx_flat_in_sector(before, at, fb)))
            return false;
        before = at;
    }
    return true;
}

bool dx_delaunay_is_clear(const struct dx_delaunay_run *run, uint32_t a, uint32_t b, uint32_t c)
{
    return is_clear(run, a, b, c) && is_clear(run, b, c, a) && is_clear(run, c, a, b);
}

int dx_delaunay_put(struct dx_delaunay_run *run, uint32_t v, uint32_t a, uint32_t b)
{
    const int rc = dx_ring_add(&run->rings, &run->ring[v], a, b);

    if (rc == DX_RING_CLOSED) {
        dx_ring_free(&run->rings, &run->ring[v]);
        run->ring[v] = DX_RING_WHOLE;
    }
    return rc < 0 ? rc : 0;
}

int dx_delaunay_give(struct dx_delaunay_run *run, uint32_t a, uint32_t b, uint32_t c)
{
    const uint32_t *index = run->cloud->index;

    run->stats->n_triangles++;
    return run->sink->triangle(run->sink->ctx, (uint32_t[3]){index[a], index[b], index[c]});
}

int dx_delaunay_add(struct dx_delaunay_run *run, uint32_t a, uint32_t b, uint32_t c)
{
    if (dx_delaunay_put(run, a, b, c) < 0 || dx_delaunay_put(run, b, c, a) < 0 ||
        dx_delaunay_put(run, c, a, b) < 0)
        return -ENOMEM;
    return dx_delaunay_give(run, a, b, c);
}
