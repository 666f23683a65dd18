/*
 * From stars to a mesh. Triangles that all three corners find cannot be in each other's way: at
 * each corner they are wedges of one star. So they are given out as they are, and a point all of
 * whose wedges are such is done. What two corners find contends for the room that is left: the
 * smallest circles first, then the lowest ranks, whatever the order in which they were found.
 */
#include "core/cloud/delaunay_priv.h"

#include <errno.h>
#include <stdlib.h>

#define ALL 3

struct contender {
    double circle; /* squared radius */
    uint32_t v[3]; /* from the lowest on */
};

static uint32_t next_in(const uint32_t *w, uint32_t n, uint32_t k)
{
    return DX_STAR_RANK(w[k + 1 < n ? k + 1 : 0]);
}

static bool is_agreed(const struct dx_stars *s, uint32_t rank)
{
    const uint8_t *vote = dx_star_votes(s, rank);

    for (uint32_t k = 0; k < s->count[rank]; k++)
        if (vote[k] != ALL)
            return false;
    return s->count[rank] >= 3;
}

/* Gives out the triangles of which r is the lowest corner, and keeps r's ring if it is open. */
static int take_agreed(struct dx_delaunay_run *run, uint32_t r)
{
    const struct dx_stars *s = &run->stars;
    const uint32_t n = s->count[r], *w = dx_star_words(s, r);
    const uint8_t *vote = dx_star_votes(s, r);
    const bool whole = is_agreed(s, r);
    int rc = 0;

    run->ring[r] = whole ? DX_RING_WHOLE : 0;
    run->stats->n_open += !whole;
    for (uint32_t k = 0; k < n && rc == 0; k++) {
        const uint32_t a = w[k], b = next_in(w, n, k);

        if (vote[k] != ALL)
            continue;
        if (r < a && r < b) {
            run->stats->n_by_votes[ALL]++;
            rc = dx_delaunay_give(run, r, a, b);
        }
        if (!whole && rc == 0)
            rc = dx_delaunay_put(run, r, a, b);
    }
    return rc;
}

/* Squared radius of the circle through three points, in space. */
static double circle_of(const struct dx_delaunay_run *run, const uint32_t v[3])
{
    const int32_t *a = run->cloud->at[v[0]], *b = run->cloud->at[v[1]], *c = run->cloud->at[v[2]];
    double p[3], q[3], pp = 0, qq = 0, rr = 0, nn = 0;

    for (int k = 0; k < 3; k++) {
        p[k] = b[k] - a[k];
        q[k] = c[k] - a[k];
        pp += p[k] * p[k];
        qq += q[k] * q[k];
        rr += (p[k] - q[k]) * (p[k] - q[k]);
    }
    for (int k = 0; k < 3; k++) {
        const double x = p[(k + 1) % 3] * q[(k + 2) % 3] - p[(k + 2) % 3] * q[(k + 1) % 3];

        nn += x * x;
    }
    return pp * qq * rr / (4 * nn);
}

static int by_circle(const void *a, const void *b)
{
    const struct contender *x = a, *y = b;

    if (x->circle != y->circle)
        return x->circle < y->circle ? -1 : 1;
    for (int k = 0; k < 3; k++)
        if (x->v[k] != y->v[k])
            return x->v[k] < y->v[k] ? -1 : 1;
    return 0;
}

/* Of r's wedges, those with so many votes of which it is the first corner that finds them: where
 * the corner before it has none. Returns how many; `out` may be NULL. */
static uint32_t list_of(struct contender *out, const struct dx_delaunay_run *run, uint32_t r,
                        uint32_t votes)
{
    const struct dx_stars *s = &run->stars;
    const uint32_t n = s->count[r], *w = dx_star_words(s, r);
    const uint8_t *vote = dx_star_votes(s, r);
    uint32_t sum = 0;

    for (uint32_t k = 0; k < n; k++) {
        uint32_t v[3] = {r, w[k], next_in(w, n, k)};

        if (vote[k] != votes)
            continue;
        while (v[0] > v[1] || v[0] > v[2]) {
            const uint32_t first = v[0];

            v[0] = v[1];
            v[1] = v[2];
            v[2] = first;
        }
        if (out)
            out[sum] = (struct contender){circle_of(run, v), {v[0], v[1], v[2]}};
        sum++;
    }
    return sum;
}

static int contend(struct dx_delaunay_run *run, struct contender *list, size_t n, uint32_t votes)
{
    int rc = 0;

    qsort(list, n, sizeof(*list), by_circle);
    for (size_t k = 0; k < n && rc == 0; k++) {
        const uint32_t *v = list[k].v;

        if (k > 0 && by_circle(&list[k - 1], &list[k]) == 0)
            continue; /* of its other corner */
        if (!dx_delaunay_fits(run, v[0], v[1], v[2]) ||
            !dx_delaunay_is_clear(run, v[0], v[1], v[2]))
            continue;
        run->stats->n_by_votes[votes]++;
        rc = dx_delaunay_add(run, v[0], v[1], v[2]);
    }
    return rc;
}

static int take_votes(struct dx_delaunay_run *run, uint32_t votes)
{
    struct contender *list;
    size_t n = 0;
    int rc;

    for (uint32_t r = 0; r < run->cloud->n; r++)
        if (run->ring[r] != DX_RING_WHOLE)
            n += list_of(NULL, run, r, votes);
    if (n == 0)
        return 0;
    list = malloc(n * sizeof(*list));
    if (!list)
        return -ENOMEM;
    n = 0;
    for (uint32_t r = 0; r < run->cloud->n; r++)
        if (run->ring[r] != DX_RING_WHOLE)
            n += list_of(list + n, run, r, votes);
    rc = contend(run, list, n, votes);
    free(list);
    return rc;
}

int dx_delaunay_accept(struct dx_delaunay_run *run)
{
    int rc = 0;

    for (uint32_t r = 0; r < run->cloud->n && rc == 0; r++)
        rc = take_agreed(run, r);
    for (uint32_t votes = ALL - 1; votes >= 1 && rc == 0; votes--)
        rc = take_votes(run, votes);
    return rc;
}
