/*
 * All nearest neighbours: spheres around points that follow each other in rank, which are
 * neighbours themselves, have about one radius, so the last point's tells how far to look. Pool
 * tasks are runs of ranks.
 */
#include "core/cloud/neighbours.h"

#include "core/cloud/few_sort.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define RUN       1024 /* points of a task */
#define ROOM      1.12 /* over the radius that held the last point's neighbours */
#define WIDEN     1.4
#define NARROW    0.6
#define MAX_TRIES 4
#define MAX_FOUND 255               /* a place is in the low byte of a key */
#define COARSE    ((1 << 23) - 1.0) /* the rest of it */
#define MAX_REACH (1 << 27)

struct all {
    struct dx_neighbours *nb;
    const struct dx_cloud *cloud;
};

/* Order of distance, then of place, which is that of rank. Coarse keys give places; what is next to
 * each other is then compared exactly. */
static void sort(uint32_t *order, const struct dx_near *near, uint32_t n, double radius)
{
    const double scale = COARSE / (radius * radius + 1);
    int32_t key[MAX_FOUND + DX_FEW_LANES], place[MAX_FOUND + DX_FEW_LANES];

    for (uint32_t i = 0; i < n; i++)
        key[i] = (int32_t)((uint32_t)((double)near[i].d2 * scale) << 8 | i);
    for (uint32_t i = n; i % DX_FEW_LANES; i++)
        key[i] = 0; /* is not counted */
    dx_few_places(place, key, n);
    for (uint32_t i = 0; i < n; i++)
        order[place[i]] = i;
    for (uint32_t i = 1; i < n; i++) {
        const uint32_t x = order[i];
        uint32_t j = i;

        for (; j > 0 && near[order[j - 1]].d2 > near[x].d2; j--)
            order[j] = order[j - 1];
        order[j] = x;
    }
}

/* Of the points in a sphere. Returns the square of the radius that the k nearest need, or that
 * there are too few or too many. */
enum { TOO_FEW = -1, TOO_MANY = -2 };

static int64_t nearest_in(uint32_t *out, const struct all *a, uint32_t rank, double radius)
{
    struct dx_near near[MAX_FOUND];
    uint32_t order[MAX_FOUND];
    const uint32_t k = a->nb->k;
    uint32_t n;

    n = dx_cloud_within(a->cloud, a->cloud->at[rank], (int32_t)radius, near, MAX_FOUND);
    if (n > MAX_FOUND || n <= k)
        return n > MAX_FOUND ? TOO_MANY : TOO_FEW;
    sort(order, near, n, radius);
    /* NOLINTBEGIN(clang-analyzer-core.uninitialized.ArraySubscript): order has all places */
    for (uint32_t i = 0; i < k; i++) /* the first is the point itself */
        out[i] = near[order[i + 1]].rank;
    return near[order[k]].d2;
    /* NOLINTEND(clang-analyzer-core.uninitialized.ArraySubscript) */
}

/* By frames of dexels, for any distance. */
static double nearest_far(uint32_t *out, const struct all *a, uint32_t rank)
{
    struct dx_near near[DX_CLOUD_MAX_NEAREST];
    const uint32_t n = dx_cloud_nearest(a->cloud, rank, a->nb->k, near);

    for (uint32_t i = 0; i < n; i++)
        out[i] = near[i].rank;
    return sqrt((double)near[n - 1].d2);
}

/* Returns the distance of the farthest. */
static double find(uint32_t *out, const struct all *a, uint32_t rank, double radius)
{
    for (int try = 0; try < MAX_TRIES && radius >= 1 && radius < MAX_REACH; try++) {
        const int64_t d2 = nearest_in(out, a, rank, radius);

        if (d2 >= 0)
            return sqrt((double)d2);
        radius *= d2 == TOO_FEW ? WIDEN : NARROW;
    }
    return nearest_far(out, a, rank);
}

static void find_run(void *ctx, uint32_t task, unsigned thread)
{
    const struct all *a = ctx;
    const uint32_t first = task * RUN;
    const uint32_t end = a->cloud->n - first < RUN ? a->cloud->n : first + RUN;
    double reach = 0;

    (void)thread;
    for (uint32_t r = first; r < end; r++)
        reach = find(a->nb->rank + (size_t)r * a->nb->k, a, r, ROOM * reach);
}

int dx_neighbours_init(struct dx_neighbours *nb, const struct dx_cloud *c, uint32_t k,
                       struct dx_pool *pool, struct dx_err *err)
{
    struct all a = {nb, c};

    *nb = (struct dx_neighbours){.n = c->n};
    if (k < 1 || k > DX_CLOUD_MAX_NEAREST)
        return dx_err_set(err, -EINVAL, "%u neighbours, expected 1 to %d", k, DX_CLOUD_MAX_NEAREST);
    nb->k = k < c->n ? k : c->n - (c->n > 0);
    nb->rank = malloc(((size_t)nb->n * nb->k + 1) * sizeof(*nb->rank)); /* of one point, too */
    if (!nb->rank) {
        *nb = (struct dx_neighbours){0};
        return dx_err_set(err, -ENOMEM, "no memory for the neighbours of %u points", c->n);
    }
    if (nb->k > 0)
        dx_pool_run(pool, (nb->n + RUN - 1) / RUN, find_run, &a);
    return 0;
}

void dx_neighbours_fini(struct dx_neighbours *nb)
{
    free(nb->rank);
    *nb = (struct dx_neighbours){0};
}
