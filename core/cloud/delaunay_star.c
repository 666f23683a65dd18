/*
 * The Delaunay neighbours of the point in the middle of others that are ordered by angle (section
 * 5.4.2). Turned inside out, x / |x|^2, they are the corners of a convex hull, and the paper's
 * backtracking is Graham's scan of it; the nearest point is the farthest then, so that the scan may
 * begin and end there. The paper's test, of bisectors, is wrong across half a turn or more: there
 * nothing hides the point between. Here it is that of an empty circle, in integers.
 */
#include "core/cloud/delaunay_priv.h"

#include <math.h>

/* A point and its image, in units of the inside out nearest. */
struct image {
    double x, y;
    uint32_t k;
};

struct scan {
    const struct dx_flat *at;
    const uint32_t *rank;
    uint32_t origin, n;
    struct image list[DX_STAR_MAX];
};

/* Images are at most 1 from the middle, and each coordinate is off by less than 2^-51 of it. */
#define UNSURE 0x1p-47

/* Where four points are on one circle: the diagonal from the lowest rank, whoever asks. */
static bool wins_tie(const struct scan *s, uint32_t a, uint32_t b, uint32_t c)
{
    const uint32_t own = s->origin < s->rank[b] ? s->origin : s->rank[b];

    return own < s->rank[a] && own < s->rank[c];
}

/* B stays a neighbour between A and C. */
static bool stays(const struct scan *s, const struct image *a, const struct image *b,
                  const struct image *c)
{
    const double turn = (b->x - a->x) * (c->y - b->y) - (b->y - a->y) * (c->x - b->x);
    int in;

    if (turn > UNSURE || dx_flat_cross(s->at[a->k], s->at[c->k]) <= 0)
        return true;
    if (turn < -UNSURE)
        return false;
    in = dx_flat_in_circle(s->at[a->k], s->at[c->k], s->at[b->k]);
    return in > 0 || (in == 0 && wins_tie(s, a->k, b->k, c->k));
}

static bool is_behind(struct dx_flat a, struct dx_flat b)
{
    return dx_flat_cross(a, b) == 0 && dx_flat_dot(a, b) > 0;
}

static void drop_hidden(struct scan *s, const struct image *next)
{
    while (s->n >= 2 && !stays(s, &s->list[s->n - 2], &s->list[s->n - 1], next))
        s->n--;
}

static uint32_t nearest(const struct dx_flat *at, const uint32_t *rank, uint32_t n)
{
    int64_t least = dx_flat_dot(at[0], at[0]);
    uint32_t best = 0;

    for (uint32_t k = 1; k < n; k++) {
        const int64_t d2 = dx_flat_dot(at[k], at[k]);

        if (d2 < least || (d2 == least && rank[k] < rank[best])) {
            least = d2;
            best = k;
        }
    }
    return best;
}

static struct image image_of(struct dx_flat at, double nearest, uint32_t k)
{
    const double x = at.x, y = at.y, turn = nearest / (x * x + y * y);

    return (struct image){x * turn, y * turn, k};
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

void dx_star_scan(struct dx_star *star, const struct dx_flat *at, const uint32_t *rank, uint32_t n,
                  uint32_t origin)
{
    struct scan s;
    uint32_t first;
    double unit;

    star->n = 0;
    if (n == 0)
        return;
    s.at = at;
    s.rank = rank;
    s.origin = origin;
    s.n = 0;
    first = nearest(at, rank, n);
    unit = sqrt((double)dx_flat_dot(at[first], at[first]));
    s.list[s.n++] = image_of(at[first], unit, first);
    for (uint32_t i = 1; i < n; i++) {
        const uint32_t k = first + i < n ? first + i : first + i - n;
        const struct image next = image_of(at[k], unit, k);

        if (is_behind(at[k > 0 ? k - 1 : n - 1], at[k]))
            continue;
        drop_hidden(&s, &next);
        if (s.n == DX_STAR_MAX)
            break;
        s.list[s.n++] = next;
    }
    drop_hidden(&s, &s.list[0]);
    star->n = s.n;
    for (uint32_t k = 0; k < s.n; k++) {
        const uint32_t here = s.list[k].k, after = s.list[k + 1 < s.n ? k + 1 : 0].k;

        star->rank[k] = rank[here];
        star->at[k] = at[here];
        star->circle[k] = diameter(at[here], at[after]);
    }
}
