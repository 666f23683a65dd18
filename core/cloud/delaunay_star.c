/*
 * The Delaunay neighbours of the point in the middle of others that are ordered by angle (section
 * 5.4.2). Turned inside out, x / |x|^2, they are the corners of a convex hull, and the paper's
 * backtracking is Graham's scan of it; the nearest point is the farthest then, so that the scan may
 * begin and end there. The paper's test, of bisectors, is wrong across half a turn or more: there
 * nothing hides the point between. Here it is that of an empty circle, in integers.
 */
#include "core/cloud/delaunay_priv.h"

#include <math.h>

struct scan {
    const struct dx_angle *list[DX_STAR_MAX];
    uint32_t n, origin;
};

/* Where four points are on one circle: the diagonal from the lowest rank, whoever asks. */
static bool wins_tie(const struct scan *s, uint32_t a, uint32_t b, uint32_t c)
{
    const uint32_t own = s->origin < b ? s->origin : b, other = a < c ? a : c;

    return own < other;
}

/* B stays a neighbour between A and C. */
static bool stays(const struct scan *s, const struct dx_angle *a, const struct dx_angle *b,
                  const struct dx_angle *c)
{
    int in;

    if (dx_flat_cross(a->at, c->at) <= 0)
        return true;
    in = dx_flat_in_circle(a->at, c->at, b->at);
    return in > 0 || (in == 0 && wins_tie(s, a->number, b->number, c->number));
}

static bool is_behind(const struct dx_angle *a, const struct dx_angle *b)
{
    return dx_flat_cross(a->at, b->at) == 0 && dx_flat_dot(a->at, b->at) > 0;
}

static void drop_hidden(struct scan *s, const struct dx_angle *next)
{
    while (s->n >= 2 && !stays(s, s->list[s->n - 2], s->list[s->n - 1], next))
        s->n--;
}

static uint32_t nearest(const struct dx_angle *order, uint32_t n)
{
    int64_t least = dx_flat_dot(order[0].at, order[0].at);
    uint32_t at = 0;

    for (uint32_t k = 1; k < n; k++) {
        const int64_t d2 = dx_flat_dot(order[k].at, order[k].at);

        if (d2 < least || (d2 == least && order[k].number < order[at].number)) {
            least = d2;
            at = k;
        }
    }
    return at;
}

/* Of the circle through the middle, a and b. */
static double diameter(struct dx_flat a, struct dx_flat b)
{
    const int64_t cross = dx_flat_cross(a, b);
    const struct dx_flat c = dx_flat_minus(b, a);

    if (cross <= 0)
        return INFINITY;
    return sqrt((double)dx_flat_dot(a, a)) * sqrt((double)dx_flat_dot(b, b)) *
           sqrt((double)dx_flat_dot(c, c)) / (double)cross;
}

void dx_star_scan(struct dx_star *star, const struct dx_angle *order, uint32_t n, uint32_t origin)
{
    struct scan s = {.origin = origin};
    uint32_t first;

    star->n = 0;
    if (n == 0)
        return;
    first = nearest(order, n);
    s.list[s.n++] = &order[first];
    for (uint32_t i = 1; i < n; i++) {
        const struct dx_angle *next = &order[first + i < n ? first + i : first + i - n];

        if (is_behind(&order[next == order ? n - 1 : (uint32_t)(next - order) - 1], next))
            continue;
        drop_hidden(&s, next);
        if (s.n == DX_STAR_MAX)
            break;
        s.list[s.n++] = next;
    }
    drop_hidden(&s, s.list[0]);
    star->n = s.n;
    for (uint32_t k = 0; k < s.n; k++) {
        star->rank[k] = s.list[k]->number;
        star->at[k] = s.list[k]->at;
        star->circle[k] = diameter(s.list[k]->at, s.list[k + 1 < s.n ? k + 1 : 0]->at);
    }
}
