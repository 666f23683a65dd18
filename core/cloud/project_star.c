/*
 * The triangles that r lacks (section 4.2): in each open sector of its plane, from the boundary
 * edge that begins it to the left, one after the other, and where that comes to an end, from the
 * edge that ends it to the right. Which of the visible points is next, the paper leaves open.
 */
#include "core/cloud/project_priv.h"

#include <math.h>

#define MAX_TRIES 12  /* points that turn out not to be visible, at one side */
#define WIDER     1.2 /* than the circle: a wider plane turns a little, and more is missing */
#define HOLLOW    1.5 /* widest radii: no surface in an empty circle of this diameter */

/* Consecutive places in the order around r, from `from` to `to`; the whole turn when equal. */
struct sector {
    uint32_t from, to;
};

struct side {
    struct dx_project_run *run;
    bool leftward; /* from sector.from towards sector.to */
    bool may_widen, narrow;
    bool refused[DX_PROJECT_MAX_CAND]; /* by place in the order */
};

static uint32_t next_of(const struct dx_local *l, uint32_t k)
{
    return k + 1 < l->n_order ? k + 1 : 0;
}

static uint32_t previous_of(const struct dx_local *l, uint32_t k)
{
    return k > 0 ? k - 1 : l->n_order - 1;
}

/* The circle through the origin, a and b: its squared diameter, over that of radius 1. */
static double diameter2(struct dx_flat a, struct dx_flat b)
{
    const double ax = a.x, ay = a.y, bx = b.x, by = b.y;
    const double cross = (ax * by - ay * bx) * DX_PROJECT_FLAT, cx = bx - ax, cy = by - ay;

    return (ax * ax + ay * ay) * (bx * bx + by * by) * (cx * cx + cy * cy) / (cross * cross);
}

/* No surface is made where a circle this wide has no sample: flat triangles along rims. */
static bool is_hollow(const struct dx_project_run *run, double d2)
{
    const double most = HOLLOW * run->widest / run->radius;

    return run->config->choice == DX_PROJECT_WIDEST && d2 > most * most;
}

/* Points beyond the radius may be in the triangle's circle; how much wider it must be. */
static bool is_unsure(struct dx_project_run *run, double d2)
{
    double wanted;

    if (run->config->choice != DX_PROJECT_WIDEST || !(d2 > 1))
        return false;
    wanted = WIDER * sqrt(d2);
    run->widen = wanted < run->widen ? wanted : run->widen;
    return true;
}

/* The candidates are near r; the edge that closes the triangle is bounded too. */
static bool is_long(const struct dx_project_run *run, const int32_t *x, const int32_t *y)
{
    double dd = 0;

    for (int k = 0; k < 3; k++)
        dd += (double)(x[k] - y[k]) * (x[k] - y[k]);
    return run->max_edge > 0 && dd > run->max_edge * run->max_edge;
}

static bool is_wide(const struct dx_project_run *run, const int32_t *x, const int32_t *y)
{
    const int32_t *r = run->cloud->at[run->r];
    double dot = 0, xx = 0, yy = 0;

    for (int k = 0; k < 3; k++) {
        const double a = x[k] - r[k], b = y[k] - r[k];

        dot += a * b;
        xx += a * a;
        yy += b * b;
    }
    if (dot >= 0 && run->cos_alpha <= 0)
        return false;
    return dot < run->cos_alpha * sqrt(xx * yy);
}

/* Positive when q is ahead of p at this side. */
static int64_t turn(const struct side *s, struct dx_flat p, struct dx_flat q)
{
    const int64_t cross = dx_flat_cross(p, q);

    return s->leftward ? cross : -cross;
}

/* How wide the angle is at which q sees r and p: over the smaller of two cotangents is the wider
 * angle. */
struct view {
    int64_t dot, cross; /* cross is positive */
};

/* 1: a is wider, -1: b is. Products have up to 120 bits; in doubles each rounds three times. */
static int compare_views(struct view a, struct view b)
{
    const double p = (double)a.dot * (double)b.cross, q = (double)b.dot * (double)a.cross;
    const double unsure = 0x1p-50 * (fabs(p) + fabs(q));
    __int128 exact;

    if (fabs(p - q) > unsure)
        return p < q ? 1 : -1;
    exact = (__int128)a.dot * b.cross - (__int128)b.dot * a.cross;
    return exact < 0 ? 1 : -(exact > 0);
}

/* Of the candidates between, the one whose circle with r and the point at `at` has no other in it:
 * it sees these two at the widest angle. UINT32_MAX: there is none. Ties go to the lower rank, as
 * if it were a little nearer. */
static uint32_t pick_widest(const struct side *s, uint32_t at, uint32_t end)
{
    const struct dx_local *l = &s->run->local;
    const struct dx_flat p = l->order[at].at;
    uint32_t best = UINT32_MAX, k = at;
    struct view widest = {0};

    do {
        const struct dx_flat q = l->order[k = s->leftward ? next_of(l, k) : previous_of(l, k)].at;
        struct view v = {0, turn(s, p, q)};
        int wider = 1;

        if (k == at || v.cross <= 0)
            break;
        if (s->refused[k])
            continue;
        v.dot = dx_flat_dot(q, dx_flat_minus(q, p));
        if (best != UINT32_MAX)
            wider = compare_views(v, widest);
        if (wider > 0 || (wider == 0 && l->id[l->order[k].number] < l->id[l->order[best].number])) {
            best = k;
            widest = v;
        }
    } while (k != end);
    return best;
}

/* Up to half a turn from the point at `at`, not beyond `end`: the next not refused; UINT32_MAX:
 * none. */
static uint32_t pick_next(const struct side *s, uint32_t at, uint32_t end)
{
    const struct dx_local *l = &s->run->local;
    const struct dx_flat p = l->order[at].at;
    uint32_t k = at;

    do {
        k = s->leftward ? next_of(l, k) : previous_of(l, k);
        if (k == at || turn(s, p, l->order[k].at) <= 0)
            break;
        if (!s->refused[k])
            return k;
    } while (k != end);
    return UINT32_MAX;
}

static double cos_between(struct dx_flat a, struct dx_flat b)
{
    const double ax = a.x, ay = a.y, bx = b.x, by = b.y;

    return (ax * bx + ay * by) / sqrt((ax * ax + ay * ay) * (bx * bx + by * by));
}

/* The cosine of the narrowest angle of the triangle with r. */
static double sharpest(struct dx_flat a, struct dx_flat b)
{
    const struct dx_flat ab = dx_flat_minus(b, a), ba = dx_flat_minus(a, b);
    const double at_r = cos_between(a, b);
    const double at_a = cos_between(ab, (struct dx_flat){-a.x, -a.y});
    const double at_b = cos_between(ba, (struct dx_flat){-b.x, -b.y});
    const double at_ends = at_a > at_b ? at_a : at_b;

    return at_r > at_ends ? at_r : at_ends;
}

/*
 * The paper's pruning by angle: of the candidates that trap no other in the triangle with r and the
 * point at `at`, the next if it is at an angle of beta or more; else the first that is; else the
 * one with the least sharp triangle. The paper leaves this choice open.
 */
static uint32_t pick_beta(struct side *s, uint32_t at, uint32_t end)
{
    const struct dx_local *l = &s->run->local;
    const struct dx_flat p = l->order[at].at;
    uint32_t best = UINT32_MAX, k = at, n_between = 0;
    struct dx_flat between[DX_PROJECT_MAX_CAND];
    double best_cos = 2;

    do {
        struct dx_flat q;
        bool traps = false;
        double c;

        q = l->order[k = s->leftward ? next_of(l, k) : previous_of(l, k)].at;
        if (k == at || turn(s, p, q) <= 0)
            break;
        if (s->refused[k])
            continue;
        for (uint32_t i = 0; i < n_between && !traps; i++)
            traps = turn(s, dx_flat_minus(q, p), dx_flat_minus(between[i], p)) >= 0;
        between[n_between++] = q;
        if (traps)
            continue;
        if (cos_between(p, q) <= s->run->cos_beta)
            return k;
        c = sharpest(p, q);
        if (c < best_cos) {
            best_cos = c;
            best = k;
        }
    } while (k != end);
    return best;
}

static uint32_t pick(struct side *s, uint32_t at, uint32_t end)
{
    switch (s->run->config->choice) {
    case DX_PROJECT_NEXT:
        return pick_next(s, at, end);
    case DX_PROJECT_BETA:
        return pick_beta(s, at, end);
    default:
        return pick_widest(s, at, end);
    }
}

/* One triangle at this side; *at moves on. False: there is none. */
static int step(struct side *s, uint32_t *at, uint32_t end, bool *made)
{
    struct dx_project_run *run = s->run;
    struct dx_local *l = &run->local;

    *made = false;
    for (uint32_t k = 0; k < l->n_order; k++)
        s->refused[k] = false;
    for (int try = 0; try < MAX_TRIES; try++) {
        const uint32_t k = pick(s, *at, end);
        const int32_t *x, *y;
        uint32_t a, b;
        double d2;
        int rc;

        if (k == UINT32_MAX)
            return 0;
        a = l->order[s->leftward ? *at : k].number;
        b = l->order[s->leftward ? k : *at].number;
        x = run->cloud->at[l->id[a]];
        y = run->cloud->at[l->id[b]];
        d2 = diameter2(l->at[a], l->at[b]);
        if (is_wide(run, x, y) || is_long(run, x, y) || is_hollow(run, d2) ||
            !dx_project_may_join(run, a, b)) {
            s->refused[k] = true;
            continue;
        }
        if (s->may_widen && is_unsure(run, d2)) {
            s->narrow = true;
            return 0;
        }
        rc = dx_project_add(run, run->r, l->id[a], l->id[b]);
        if (rc < 0)
            return rc;
        l->linked[a] = l->linked[b] = true;
        *at = k;
        *made = true;
        return 0;
    }
    return 0;
}

/* From both ends of a sector. */
static int fill(struct side *s, struct sector open)
{
    bool made = true;
    int rc;

    for (s->leftward = true; made;) {
        rc = step(s, &open.from, open.to, &made);
        if (rc < 0)
            return rc;
        if (made && open.from == open.to)
            return 0;
    }
    if (s->narrow)
        return 0;
    s->narrow = s->may_widen; /* something is missing: it may be farther */
    for (s->leftward = false, made = true; made;) {
        rc = step(s, &open.to, open.from, &made);
        if (rc < 0 || (made && open.from == open.to))
            return rc;
    }
    return 0;
}

static uint32_t order_of(const struct dx_local *l, uint32_t place)
{
    for (uint32_t k = 0; k < l->n_order; k++)
        if (l->order[k].number == place)
            return k;
    return UINT32_MAX;
}

/* The nearest point that r sees: an edge of any triangulation by circles. */
static uint32_t first_neighbour(const struct dx_project_run *run)
{
    const struct dx_local *l = &run->local;
    uint32_t best = UINT32_MAX;
    int64_t best_dd = 0;

    for (uint32_t k = 0; k < l->n_order; k++) {
        const int64_t dd = dx_flat_dot(l->order[k].at, l->order[k].at);

        if ((best == UINT32_MAX || dd < best_dd) && dx_project_sees(run, l->order[k].number)) {
            best = k;
            best_dd = dd;
        }
    }
    return best;
}

/* From the end of a chain to the left, the first start of any. */
static bool find_sector(struct sector *open, const struct dx_local *l, uint32_t chain)
{
    open->from = open->to = order_of(l, l->own[chain].last);
    if (open->from == UINT32_MAX)
        return false;
    for (uint32_t n = 0; n < l->n_order; n++) {
        open->to = next_of(l, open->to);
        for (uint32_t i = 0; i < l->n_own; i++)
            if (l->order[open->to].number == l->own[i].first)
                return true;
    }
    return false;
}

int dx_project_star(struct dx_project_run *run, bool may_widen)
{
    struct dx_local *l = &run->local;
    struct side s = {.run = run, .may_widen = may_widen};
    struct sector open;
    int rc = 0;

    if (l->n_own == 0) {
        open.from = open.to = first_neighbour(run);
        if (open.from != UINT32_MAX)
            rc = fill(&s, open);
    }
    for (uint32_t k = 0; k < l->n_own && rc == 0; k++)
        if (find_sector(&open, l, k))
            rc = fill(&s, open);
    return rc < 0 ? rc : s.narrow ? DX_STAR_NARROW : DX_STAR_DONE;
}
