/* Points near a point: boxes of dexels, which are runs of ranks by rows, pruned by the sphere. */
#include "core/cloud/dexels.h"

#include <math.h>
#include <stdbool.h>

#define FEW 12 /* points of a dexel */

struct query {
    const int32_t *p;
    int64_t r2;
    int32_t last; /* depth, in the row */
    struct dx_near *out;
    uint32_t n, max;
};

/* The first of ranks `from` to `end`, of one dexel, that is not before this depth. Without
 * branches: where it is, cannot be foretold. */
static uint32_t find_depth(const struct dx_cloud *c, uint32_t from, uint32_t end, int32_t depth)
{
    uint32_t n = end - from;

    while (n > 1) {
        const uint32_t half = n / 2;

        from += c->at[from + half - 1][2] < depth ? half : 0;
        n -= half;
    }
    return from + (n == 1 && c->at[from][2] < depth);
}

/* The same, or earlier where looking for it would take longer than what is then looked at. */
static uint32_t skip(const struct dx_cloud *c, uint32_t from, uint32_t end, int32_t depth)
{
    return end - from > FEW ? find_depth(c, from, end, depth) : from;
}

static inline int64_t distance2(const int32_t a[3], const int32_t b[3])
{
    const int64_t dx = a[0] - b[0], dy = a[1] - b[1], dz = a[2] - b[2];

    return dx * dx + dy * dy + dz * dz;
}

/* Points of one dexel from a depth on. Where there is room for all, all are written, and the next
 * goes over one that is too far: no branch tells them apart. */
static void scan(struct query *q, const struct dx_cloud *c, uint32_t from, uint32_t end)
{
    const int64_t r2 = q->r2;
    const int32_t last = q->last;
    struct dx_near *out = q->out + q->n;

    if (q->n > q->max || end - from > q->max - q->n) {
        for (; from < end && c->at[from][2] <= last; from++) {
            const int64_t d2 = distance2(c->at[from], q->p);

            if (d2 > r2)
                continue;
            if (q->n < q->max)
                q->out[q->n] = (struct dx_near){d2, from};
            q->n++;
        }
        return;
    }
    for (; from < end && c->at[from][2] <= last; from++) {
        out->d2 = distance2(c->at[from], q->p);
        out->rank = from;
        out += out->d2 <= r2;
    }
    q->n = (uint32_t)(out - q->out);
}

/* How far a point with this coordinate is from row i; the outermost have no end. */
static int64_t away_from(const struct dx_cloud *c, uint32_t i, int32_t x)
{
    const int64_t begin = (int64_t)c->low[0] + (int64_t)i * c->side;

    if (x < begin)
        return i > 0 ? begin - x : 0;
    return x >= begin + c->side && i + 1 < c->rows ? x - begin - c->side : 0;
}

/* How far the sphere reaches along a row of dexels and in depth, where the row's nearest points are
 * `away` from its centre; rounded up. */
static int32_t half_chord(int32_t radius, int64_t away)
{
    const double r = radius, d = (double)away;

    return away > 0 ? (int32_t)sqrt(r * r - d * d) + 1 : radius;
}

uint32_t dx_cloud_within(const struct dx_cloud *c, const int32_t p[3], int32_t radius,
                         struct dx_near *out, uint32_t max)
{
    struct query q = {p, (int64_t)radius * radius, 0, out, 0, max};
    uint32_t row, last_row;

    if (c->n == 0)
        return 0;
    row = dx_dexel_place(c, 0, (int64_t)p[0] - radius);
    last_row = dx_dexel_place(c, 0, (int64_t)p[0] + radius);
    for (; row <= last_row; row++) {
        const uint32_t *start = c->start + (size_t)row * c->cols;
        const int32_t reach = half_chord(radius, away_from(c, row, p[0]));
        const uint32_t first = dx_dexel_place(c, 1, (int64_t)p[1] - reach),
                       last = dx_dexel_place(c, 1, (int64_t)p[1] + reach);

        q.last = p[2] + reach;
        for (uint32_t j = first; j <= last; j++)
            __builtin_prefetch(c->at[start[j]]);
        for (uint32_t j = first; j <= last; j++)
            scan(&q, c, skip(c, start[j], start[j + 1], p[2] - reach), start[j + 1]);
    }
    return q.n;
}

static bool is_nearer(struct dx_near a, struct dx_near b)
{
    return a.d2 < b.d2 || (a.d2 == b.d2 && a.rank < b.rank);
}

/* Keeps the k nearest of `found` in `out`, which has n. */
static uint32_t keep(struct dx_near *out, uint32_t n, uint32_t k, struct dx_near found)
{
    uint32_t j;

    if (n == k && !is_nearer(found, out[k - 1]))
        return n;
    n += n < k;
    for (j = n - 1; j > 0 && is_nearer(found, out[j - 1]); j--)
        out[j] = out[j - 1];
    out[j] = found;
    return n;
}

struct search {
    const struct dx_cloud *cloud;
    uint32_t rank, k, n;
    struct dx_near *out;
};

/* Of the dexels' ranks `from` to `end`. */
static void search_run(struct search *s, uint32_t from, uint32_t end)
{
    for (uint32_t r = from; r < end; r++)
        if (r != s->rank)
            s->n = keep(s->out, s->n, s->k,
                        (struct dx_near){distance2(s->cloud->at[r], s->cloud->at[s->rank]), r});
}

/* The frame of dexels at distance `ring` from dexel (i, j); false: it is all outside. */
static bool search_ring(struct search *s, int64_t i, int64_t j, int64_t ring)
{
    const struct dx_cloud *c = s->cloud;
    const int64_t left = j - ring, right = j + ring;
    const int64_t from = left > 0 ? left : 0, to = right < c->cols ? right : c->cols - 1;
    bool inside = false;

    for (int64_t row = i - ring; row <= i + ring; row++) {
        const uint32_t *start = c->start + row * c->cols;

        if (row < 0 || row >= c->rows)
            continue;
        if (row == i - ring || row == i + ring) {
            search_run(s, start[from], start[to + 1]);
            inside = true;
            continue;
        }
        if (left >= 0)
            search_run(s, start[left], start[left + 1]);
        if (right < c->cols)
            search_run(s, start[right], start[right + 1]);
        inside |= left >= 0 || right < c->cols;
    }
    return inside;
}

uint32_t dx_cloud_nearest(const struct dx_cloud *c, uint32_t rank, uint32_t k, struct dx_near *out)
{
    struct search s = {c, rank, k, 0, out};
    const int32_t *p = c->at[rank];
    const int64_t i = dx_dexel_place(c, 0, p[0]), j = dx_dexel_place(c, 1, p[1]);

    for (int64_t ring = 0; k > 0 && search_ring(&s, i, j, ring); ring++) {
        /* what is in no frame yet is at least so far */
        const int64_t far = ring * c->side;

        if (s.n == k && out[k - 1].d2 < far * far)
            break;
    }
    return s.n;
}
