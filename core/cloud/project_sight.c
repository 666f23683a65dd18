/*
 * Pruning by visibility (section 4.1): what r sees in its plane. Only boundary edges of the
 * candidates can be in the way (theorem 4.1). The paper looks along the lines from r; here the edge
 * that closes a triangle is looked at as well, and so is what is inside, so that no triangle is
 * made over another in the plane of the point that makes it. All of it is exact.
 */
#include "core/cloud/project_priv.h"

#define STEEP 0.975 /* sine of an edge over the plane, about 77 degrees */
#define HIGH  0.45  /* radii; what is lower may be noise */

static const struct dx_flat origin = {0, 0};

/* The place of a point; a new one for the end of a candidate's edge; -1: no room. */
static int place_of(struct dx_project_run *run, uint32_t rank)
{
    struct dx_local *l = &run->local;
    const uint32_t k = run->point[rank].local;

    if (k < l->n && l->id[k] == rank)
        return (int)k;
    if (l->n == DX_PROJECT_MAX_LOCAL)
        return -1;
    l->id[l->n] = rank;
    l->at[l->n] = dx_project_flat(run, rank);
    l->hidden[l->n] = true;
    l->linked[l->n] = l->behind[l->n] = false;
    run->point[rank].local = l->n;
    return (int)l->n++;
}

static void add_candidate(struct dx_project_run *run, uint32_t rank, struct dx_flat at)
{
    struct dx_local *l = &run->local;
    const uint32_t k = run->point[rank].local;

    if (k < l->n && l->id[k] == rank)
        return;
    if (at.x == 0 && at.y == 0) /* right above r: it has no direction */
        return;
    l->id[l->n] = rank;
    l->at[l->n] = at;
    l->hidden[l->n] = l->linked[l->n] = l->behind[l->n] = false;
    run->point[rank].local = l->n++;
}

static bool is_nearer(struct dx_near a, struct dx_near b)
{
    return a.d2 < b.d2 || (a.d2 == b.d2 && a.rank < b.rank);
}

/* The `room` nearest of the points that are not completed. */
static void add_nearest(struct dx_project_run *run, uint32_t room)
{
    uint32_t nearest[DX_PROJECT_MAX_CAND], n = 0;

    for (uint32_t k = 0; k < run->n_near && room > 0; k++) {
        const struct dx_near p = run->near[k];
        uint32_t j;

        if (run->state[p.rank] == DX_COMPLETED ||
            (n == room && !is_nearer(p, run->near[nearest[n - 1]])))
            continue;
        n -= n == room;
        for (j = n++; j > 0 && is_nearer(p, run->near[nearest[j - 1]]); j--)
            nearest[j] = nearest[j - 1];
        nearest[j] = k;
    }
    for (uint32_t k = 0; k < n; k++)
        add_candidate(run, run->near[nearest[k]].rank, dx_project_flat_near(run, nearest[k]));
}

/* near[k] is far above or below r in its plane, so that no surface runs from one to the other: it
 * would be joined through an ear of a bunny. */
static bool is_other_sheet(const struct dx_project_run *run, uint32_t k, double high2)
{
    const double *n = run->normal;
    const double h = n[0] * run->offset[0][k] + n[1] * run->offset[1][k] + n[2] * run->offset[2][k];

    return h * h > high2 && h * h > STEEP * STEEP * (double)run->near[k].d2;
}

/* What is not completed, the ends of r's chains first, since they must be there. */
static void add_candidates(struct dx_project_run *run)
{
    const uint32_t ring = run->point[run->r].ring, n = dx_ring_n(&run->rings, ring);
    const uint32_t *list = dx_ring_list(&run->rings, ring);
    const double high2 = HIGH * HIGH * run->radius * run->radius;
    uint32_t open[DX_PROJECT_MAX_NEAR], n_open = 0, room;

    for (uint32_t k = 0; k < run->n_near; k++) {
        open[n_open] = k;
        n_open += run->state[run->near[k].rank] != DX_COMPLETED && !is_other_sheet(run, k, high2);
    }
    for (uint32_t k = 0; k < n && run->local.n < DX_PROJECT_MAX_CAND; k++)
        if ((list[k] & DX_RING_FIRST) || k + 1 == n || (list[k + 1] & DX_RING_FIRST))
            add_candidate(run, list[k] & ~DX_RING_FIRST,
                          dx_project_flat(run, list[k] & ~DX_RING_FIRST));
    room = DX_PROJECT_MAX_CAND - run->local.n;
    if (n_open > room)
        add_nearest(run, room);
    for (uint32_t k = 0; k < n_open && n_open <= room; k++)
        /* NOLINTNEXTLINE(clang-analyzer-core.uninitialized.ArraySubscript): n_open are set */
        add_candidate(run, run->near[open[k]].rank, dx_project_flat_near(run, open[k]));
    run->local.n_cand = run->local.n;
}

/* The chains of a ring as places. Returns their number; -1: no room. */
static int read_chains(struct dx_project_run *run, struct dx_local_chain *out, uint32_t max,
                       uint32_t ring)
{
    const uint32_t n = dx_ring_n(&run->rings, ring), *list = dx_ring_list(&run->rings, ring);
    uint32_t count = 0;

    for (uint32_t k = 0, first; k < n; k++) {
        int a, b;

        for (first = k; k + 1 < n && !(list[k + 1] & DX_RING_FIRST);)
            k++;
        /* r itself has no place: it stands for itself */
        a = (list[first] & ~DX_RING_FIRST) == run->r ? DX_PROJECT_MAX_LOCAL
                                                     : place_of(run, list[first] & ~DX_RING_FIRST);
        b = list[k] == run->r ? DX_PROJECT_MAX_LOCAL : place_of(run, list[k]);
        if (a < 0 || b < 0 || count == max)
            return -1;
        out[count++] = (struct dx_local_chain){(uint16_t)a, (uint16_t)b, k == first + 1};
    }
    return (int)count;
}

static struct dx_flat at_place(const struct dx_local *l, uint32_t place)
{
    return place == DX_PROJECT_MAX_LOCAL ? origin : l->at[place];
}

/* An edge is listed where its filled side is to the right; from its other end when the chains of
 * that are not looked at. */
static void add_edges(struct dx_local *l, uint32_t k, const struct dx_local_chain *c)
{
    if (c->last != DX_PROJECT_MAX_LOCAL)
        l->edge[l->n_edges++] = (struct dx_local_edge){(uint16_t)k, c->last};
    if (c->first != DX_PROJECT_MAX_LOCAL && (c->first >= l->n_cand || l->behind[c->first]))
        l->edge[l->n_edges++] = (struct dx_local_edge){(uint16_t)k, c->first};
}

static bool is_filled(const struct dx_local *l, struct dx_flat from, const struct dx_local_chain *c,
                      struct dx_flat direction)
{
    const struct dx_flat a = dx_flat_minus(at_place(l, c->first), from);
    const struct dx_flat b = dx_flat_minus(at_place(l, c->last), from);

    if (c->single && dx_flat_cross(a, b) <= 0)
        return false; /* it stands on edge here, or is seen from behind */
    return dx_flat_in_sector(a, b, direction);
}

/* Step 1: what is between consecutive boundary edges of r. */
static void hide_behind(struct dx_local *l)
{
    for (uint32_t k = 0; k < l->n_cand; k++)
        for (uint32_t i = 0; i < l->n_own && !l->linked[k]; i++)
            l->behind[k] |= is_filled(l, origin, &l->own[i], l->at[k]);
    for (uint32_t k = 0; k < l->n_cand; k++)
        l->hidden[k] = l->behind[k];
}

static bool add_chains(struct dx_project_run *run)
{
    struct dx_local *l = &run->local;

    for (uint32_t k = 0; k < l->n_cand; k++) {
        int n = l->behind[k]
                    ? 0
                    : read_chains(run, l->chain + l->n_chains, DX_PROJECT_MAX_CHAINS - l->n_chains,
                                  run->point[l->id[k]].ring);

        if (n < 0)
            return false;
        l->chain_start[k] = l->n_chains;
        l->n_chains += (uint32_t)n;
        for (int i = 0; i < n; i++)
            add_edges(l, k, &l->chain[l->chain_start[k] + (uint32_t)i]);
    }
    l->chain_start[l->n_cand] = l->n_chains;
    return true;
}

/* Step 2: what has r between its own boundary edges. */
static void hide(struct dx_local *l)
{
    for (uint32_t k = 0; k < l->n_cand; k++)
        for (uint32_t i = l->chain_start[k]; i < l->chain_start[k + 1] && !l->linked[k]; i++)
            l->hidden[k] |= is_filled(l, l->at[k], &l->chain[i], dx_flat_minus(origin, l->at[k]));
}

static void set_order(struct dx_project_run *run)
{
    struct dx_local *l = &run->local;

    for (uint32_t k = 0; k < l->n_cand; k++)
        if (!l->hidden[k])
            l->order[l->n_order++] =
                (struct dx_angle){dx_angle_key(l->at[k]), l->at[k], l->id[k] /* for ties */};
    dx_angle_sort(l->order, l->n_order);
    for (uint32_t k = 0; k < l->n_order; k++)
        l->order[k].number = run->point[l->order[k].number].local;
}

bool dx_project_look(struct dx_project_run *run)
{
    struct dx_local *l = &run->local;
    int n;

    l->n = l->n_chains = l->n_edges = l->n_order = 0;
    add_candidates(run);
    n = read_chains(run, l->own, DX_RING_MAX, run->point[run->r].ring);
    if (n < 0 || l->n > l->n_cand) /* an end of r's own is right above it */
        return false;
    l->n_own = (uint32_t)n;
    for (uint32_t i = 0; i < l->n_own; i++)
        l->linked[l->own[i].first] = l->linked[l->own[i].last] = true;
    hide_behind(l);
    if (!add_chains(run))
        return false;
    hide(l);
    set_order(run);
    return true;
}

bool dx_project_sees(const struct dx_project_run *run, uint32_t place)
{
    const struct dx_local *l = &run->local;

    for (uint32_t k = 0; k < l->n_edges; k++) {
        const struct dx_local_edge e = l->edge[k];

        if (e.a != place && e.b != place &&
            dx_flat_cross_inside(origin, l->at[place], l->at[e.a], l->at[e.b]))
            return false;
    }
    return true;
}

/* Places a and b are joined by a boundary edge. */
static bool is_edge(const struct dx_local *l, uint32_t a, uint32_t b)
{
    for (uint32_t i = l->chain_start[a]; i < l->chain_start[a + 1]; i++)
        if (l->chain[i].first == b || l->chain[i].last == b)
            return true;
    return false;
}

/* A boundary edge is in the way between places a and b. */
static bool is_crossed(const struct dx_local *l, uint32_t a, uint32_t b)
{
    for (uint32_t k = 0; k < l->n_edges; k++) {
        const struct dx_local_edge e = l->edge[k];

        if (e.a != a && e.a != b && e.b != a && e.b != b &&
            dx_flat_cross_inside(l->at[a], l->at[b], l->at[e.a], l->at[e.b]))
            return true;
    }
    return false;
}

/* At place k: the triangle's wedge, left from direction `from` to `to`, overlaps a chain's. */
static bool overlaps(const struct dx_local *l, uint32_t k, struct dx_flat from, struct dx_flat to)
{
    const struct dx_flat p = dx_flat_minus(from, l->at[k]), q = dx_flat_minus(to, l->at[k]);

    for (uint32_t i = l->chain_start[k]; i < l->chain_start[k + 1]; i++) {
        const struct dx_local_chain *c = &l->chain[i];
        const struct dx_flat a = dx_flat_minus(at_place(l, c->first), l->at[k]);
        const struct dx_flat b = dx_flat_minus(at_place(l, c->last), l->at[k]);

        if (dx_flat_in_sector(p, q, a) || dx_flat_in_sector(p, q, b) ||
            is_filled(l, l->at[k], c, p) || is_filled(l, l->at[k], c, q))
            return true;
    }
    return false;
}

/* A point other than the corners is in triangle (r, a, b), or on a side that is not there yet. */
static bool traps(const struct dx_local *l, uint32_t a, uint32_t b)
{
    const struct dx_flat p = l->at[a], q = l->at[b];
    const int64_t beyond_a = l->linked[a], beyond_b = l->linked[b];

    for (uint32_t k = 0; k < l->n; k++) {
        const struct dx_flat x = l->at[k];

        if (dx_flat_cross(p, x) >= beyond_a && dx_flat_cross(x, q) >= beyond_b &&
            dx_flat_turn(p, q, x) >= 0 && k != a && k != b)
            return true;
    }
    return false;
}

bool dx_project_may_join(const struct dx_project_run *run, uint32_t a, uint32_t b)
{
    const struct dx_local *l = &run->local;

    return dx_flat_cross(l->at[a], l->at[b]) > 0 &&
           dx_project_fits(run, run->r, l->id[a], l->id[b]) && !traps(l, a, b) &&
           !overlaps(l, a, l->at[b], origin) && !overlaps(l, b, origin, l->at[a]) &&
           (l->linked[a] || dx_project_sees(run, a)) && (l->linked[b] || dx_project_sees(run, b)) &&
           (is_edge(l, a, b) || !is_crossed(l, a, b));
}
