/*
 * A minimum spanning forest by Kruskal's method, without the forest: sets of points that it has
 * joined so far, each point with its sign beside its parent's. What an edge costs is counted in
 * half octaves, so that edges need no sorting: those of the first class are joined as they come,
 * the others in the order of class, then of rank.
 */
#include "core/cloud/orient.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define RUN       1024 /* points of a task */
#define MAX_EDGES 16   /* of a point: its nearest neighbours */
#define N_CLASSES 24
#define NO_CLASS  255
#define SMOOTH    0x1p-9 /* costs below are class 0: normals less than 3.6 degrees apart */

struct forest {
    float (*n)[3];
    const struct dx_cloud *cloud;
    const struct dx_neighbours *nb;
    uint32_t k;
    uint8_t *class; /* [n][k] of edges */
    uint32_t *up;   /* [n] parent's rank << 1 | opposite sign; a root has itself */
};

static inline float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static bool is_defined(const float n[3])
{
    return n[0] != 0 || n[1] != 0 || n[2] != 0;
}

/*
 * 1 - |n.n'|, and as much again where the edge leaves both tangent planes: then it leads to another
 * sheet, whose normal may be parallel and tell nothing of sides.
 */
static float cost_of(const struct forest *f, uint32_t a, uint32_t b)
{
    const float *n = f->n[a], *m = f->n[b];
    const int32_t *p = f->cloud->at[a], *q = f->cloud->at[b];
    const float e[3] = {(float)(q[0] - p[0]), (float)(q[1] - p[1]), (float)(q[2] - p[2])};
    const float en = dot(e, n), em = dot(e, m);
    const float least = en * en < em * em ? en * en : em * em;

    return 1 - fabsf(dot(n, m)) + least / dot(e, e);
}

/* Two classes an octave: the exponent and the first bit of the mantissa. */
static uint8_t class_of(float cost)
{
    uint32_t bits, base;
    const float smooth = (float)SMOOTH;

    if (!(cost >= smooth))
        return 0;
    memcpy(&bits, &cost, sizeof(bits));
    memcpy(&base, &smooth, sizeof(base));
    bits = (bits >> 22) - (base >> 22) + 1;
    return (uint8_t)(bits < N_CLASSES ? bits : N_CLASSES - 1);
}

static bool has(const uint32_t *list, uint32_t n, uint32_t rank)
{
    uint32_t found = 0;

    for (uint32_t k = 0; k < n; k++)
        found |= list[k] == rank;
    return found;
}

/* Of the edge to r's k-th neighbour; one that both ends have is the lower end's. */
static uint8_t classify(const struct forest *f, uint32_t r, uint32_t k)
{
    const uint32_t q = dx_neighbours_of(f->nb, r)[k];

    if (!is_defined(f->n[r]) || !is_defined(f->n[q]) ||
        (q < r && has(dx_neighbours_of(f->nb, q), f->k, r)))
        return NO_CLASS;
    return class_of(cost_of(f, r, q));
}

static void classify_run(void *ctx, uint32_t task, unsigned thread)
{
    const struct forest *f = ctx;
    const uint32_t first = task * RUN, n = f->cloud->n;
    const uint32_t end = n - first < RUN ? n : first + RUN;

    (void)thread;
    for (uint32_t r = first; r < end; r++) {
        f->up[r] = r << 1;
        for (uint32_t k = 0; k < f->k; k++)
            f->class[(size_t)r * f->k + k] = classify(f, r, k);
    }
}

/* root << 1 | sign beside the root's. */
static uint32_t find(uint32_t *up, uint32_t x)
{
    uint32_t sign = 0;

    while (up[x] >> 1 != x) {
        const uint32_t parent = up[x] >> 1, above = up[parent] ^ (up[x] & 1);

        up[x] = above; /* halves the path */
        sign ^= above & 1;
        x = above >> 1;
    }
    return x << 1 | sign;
}

static void join(const struct forest *f, uint32_t a, uint32_t b)
{
    const uint32_t ra = find(f->up, a), rb = find(f->up, b);
    const uint32_t opposite = (ra ^ rb ^ (dot(f->n[a], f->n[b]) < 0)) & 1;

    if (ra >> 1 == rb >> 1)
        return;
    if (ra < rb)
        f->up[rb >> 1] = (ra & ~1u) | opposite;
    else
        f->up[ra >> 1] = (rb & ~1u) | opposite;
}

struct edge {
    uint32_t a, b;
};

/* Joins class 0, and counts what is left of each other class. */
static size_t join_smooth(const struct forest *f, size_t count[N_CLASSES])
{
    size_t n_left = 0;

    for (uint32_t r = 0; r < f->cloud->n; r++) {
        const uint32_t *near = dx_neighbours_of(f->nb, r);

        for (uint32_t k = 0; k < f->k; k++)
            if (f->class[(size_t)r * f->k + k] == 0)
                join(f, r, near[k]);
    }
    for (uint32_t r = 0; r < f->cloud->n; r++) {
        const uint32_t *near = dx_neighbours_of(f->nb, r);

        for (uint32_t k = 0; k < f->k; k++) {
            uint8_t *class = &f->class[(size_t)r * f->k + k];

            if (*class == NO_CLASS || *class == 0)
                continue;
            if (find(f->up, r) >> 1 == find(f->up, near[k]) >> 1) {
                *class = NO_CLASS;
                continue;
            }
            count[*class]++;
            n_left++;
        }
    }
    return n_left;
}

/* The others, sorted by class. */
static int join_rest(const struct forest *f)
{
    size_t at[N_CLASSES] = {0}, sum = 0;
    const size_t n = join_smooth(f, at);
    struct edge *edge;

    if (n == 0)
        return 0;
    edge = malloc(n * sizeof(*edge));
    if (!edge)
        return -ENOMEM;
    for (int c = 0; c < N_CLASSES; c++) {
        const size_t count = at[c];

        at[c] = sum;
        sum += count;
    }
    for (uint32_t r = 0; r < f->cloud->n; r++)
        for (uint32_t k = 0; k < f->k; k++) {
            const uint8_t class = f->class[(size_t)r * f->k + k];

            if (class != 0 && class != NO_CLASS)
                edge[at[class]++] = (struct edge){r, dx_neighbours_of(f->nb, r)[k]};
        }
    for (size_t i = 0; i < n; i++)
        join(f, edge[i].a, edge[i].b);
    free(edge);
    return 0;
}

/* Whether the point votes for the root's normal as it is; 0: it has no say. */
static int vote(const struct forest *f, uint32_t r, uint32_t sign, const double *viewpoint)
{
    const struct dx_cloud *c = f->cloud;
    double side = 0;

    if (!viewpoint) { /* the first axis that tells, from the depth on */
        const float *n = f->n[r];

        side = n[2] != 0 ? (double)n[2] : n[0] != 0 ? (double)n[0] : (double)n[1];
    } else {
        for (int k = 0; k < 3; k++)
            side += (double)f->n[r][k] *
                    ((viewpoint[c->axis[k]] - c->origin[k]) / c->step - c->at[r][k]);
    }
    if (sign & 1)
        side = -side;
    return (side > 0) - (side < 0);
}

/* Of each part: votes for its root's normal, of all its points or of the highest. */
static void take_votes(const struct forest *f, int64_t *votes, uint32_t *highest,
                       const double *viewpoint)
{
    for (uint32_t r = 0; r < f->cloud->n; r++) {
        const uint32_t root = find(f->up, r);

        if (viewpoint) {
            votes[root >> 1] += vote(f, r, root, viewpoint);
        } else if (r == root >> 1 || f->cloud->at[r][2] > f->cloud->at[highest[root >> 1]][2]) {
            highest[root >> 1] = r;
            votes[root >> 1] = vote(f, r, root, NULL);
        }
    }
}

static int turn(const struct forest *f, uint32_t *n_parts, const double *viewpoint)
{
    const uint32_t n = f->cloud->n;
    int64_t *votes = calloc(n, sizeof(*votes));
    uint32_t *highest = calloc(n, sizeof(*highest));

    *n_parts = 0;
    if (!votes || !highest) {
        free(votes);
        free(highest);
        return -ENOMEM;
    }
    take_votes(f, votes, highest, viewpoint);
    for (uint32_t r = 0; r < n; r++) {
        const uint32_t root = find(f->up, r);

        *n_parts += root >> 1 == r && is_defined(f->n[r]);
        if ((votes[root >> 1] < 0) != (root & 1))
            for (int k = 0; k < 3; k++)
                f->n[r][k] = -f->n[r][k];
    }
    free(votes);
    free(highest);
    return 0;
}

int dx_orient(float (*n)[3], uint32_t *n_parts, const struct dx_cloud *cloud,
              const struct dx_neighbours *nb, uint32_t k, const double *viewpoint,
              struct dx_pool *pool)
{
    struct forest f = {n, cloud, nb, k < MAX_EDGES ? k : MAX_EDGES, NULL, NULL};
    int rc = -ENOMEM;

    f.class = malloc((size_t)cloud->n * f.k + 1);
    f.up = malloc((size_t)cloud->n * sizeof(*f.up));
    if (f.class && f.up) {
        dx_pool_run(pool, (cloud->n + RUN - 1) / RUN, classify_run, &f);
        rc = join_rest(&f);
    }
    if (rc == 0)
        rc = turn(&f, n_parts, viewpoint);
    free(f.class);
    free(f.up);
    return rc;
}
