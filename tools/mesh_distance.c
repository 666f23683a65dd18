/* A tree of boxes whose nodes halve the triangles by their centres along the longest side. */
#include "tools/mesh_distance.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LEAF 4

/* ---- one triangle --------------------------------------------------------------------------- */

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void difference(double out[3], const double a[3], const double b[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = a[k] - b[k];
}

static void cross(double out[3], const double a[3], const double b[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static double segment_distance2(const double p[3], const double a[3], const double b[3])
{
    double ab[3], ap[3], len2, s;

    difference(ab, b, a);
    difference(ap, p, a);
    len2 = dot(ab, ab);
    s = len2 > 0 ? fmin(1, fmax(0, dot(ap, ab) / len2)) : 0;
    for (int k = 0; k < 3; k++)
        ap[k] -= s * ab[k];
    return dot(ap, ap);
}

double dx_triangle_distance2(const double p[3], const double a[3], const double b[3],
                             const double c[3])
{
    const double *const v[4] = {a, b, c, a};
    double ab[3], ac[3], normal[3], ap[3], best = INFINITY;
    int n_inside = 0;

    difference(ab, b, a);
    difference(ac, c, a);
    cross(normal, ab, ac);
    for (int k = 0; k < 3; k++) {
        double side[3], to[3], outward[3];

        difference(side, v[k + 1], v[k]);
        difference(to, p, v[k]);
        cross(outward, side, normal);
        n_inside += dot(outward, to) < 0;
        best = fmin(best, segment_distance2(p, v[k], v[k + 1]));
    }
    if (n_inside < 3)
        return best;
    difference(ap, p, a);
    return fmin(best, dot(ap, normal) * dot(ap, normal) / dot(normal, normal));
}

/* ---- the tree ------------------------------------------------------------------------------- */

static const double *corner(const struct dx_mesh_distance *d, uint32_t t, int k)
{
    return d->xyz + 3 * (size_t)d->index[3 * (size_t)t + (size_t)k];
}

static double centre(const struct dx_mesh_distance *d, uint32_t t, int axis)
{
    return corner(d, t, 0)[axis] + corner(d, t, 1)[axis] + corner(d, t, 2)[axis];
}

static struct dx_distance_box box_of(const struct dx_mesh_distance *d, size_t start, size_t end)
{
    struct dx_distance_box b = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

    for (size_t k = start; k < end; k++)
        for (int c = 0; c < 3; c++)
            for (int axis = 0; axis < 3; axis++) {
                const double x = corner(d, d->order[k], c)[axis];

                b.low[axis] = fmin(b.low[axis], x);
                b.high[axis] = fmax(b.high[axis], x);
            }
    return b;
}

static void swap(uint32_t *a, uint32_t *b)
{
    const uint32_t t = *a;

    *a = *b;
    *b = t;
}

/* Until those before `mid` are not above it along the axis, those from it on not below. */
static void halve(struct dx_mesh_distance *d, size_t start, size_t mid, size_t end, int axis)
{
    while (end - start > 1) {
        const double pivot = centre(d, d->order[start + (end - start - 1) / 2], axis);
        size_t i = start, j = end - 1;

        for (;;) {
            while (centre(d, d->order[i], axis) < pivot)
                i++;
            while (centre(d, d->order[j], axis) > pivot)
                j--;
            if (i >= j)
                break;
            swap(&d->order[i++], &d->order[j--]);
        }
        if (mid <= j)
            end = j + 1;
        else
            start = j + 1;
    }
}

static void build(struct dx_mesh_distance *d, size_t node, size_t start, size_t end)
{
    const size_t mid = start + (end - start) / 2;
    const struct dx_distance_box b = box_of(d, start, end);
    int axis = 0;

    d->box[node] = b;
    if (end - start <= LEAF)
        return;
    for (int k = 1; k < 3; k++)
        if (b.high[k] - b.low[k] > b.high[axis] - b.low[axis])
            axis = k;
    halve(d, start, mid, end, axis);
    build(d, 2 * node, start, mid);
    build(d, 2 * node + 1, mid, end);
}

int dx_mesh_distance_init(struct dx_mesh_distance *d, const double *xyz, const uint32_t *index,
                          size_t n)
{
    size_t n_nodes = 2;

    *d = (struct dx_mesh_distance){.xyz = xyz, .index = index, .n = n};
    if (n == 0 || n > (size_t)1 << 30)
        return -EINVAL;
    for (size_t most = n; most > LEAF; most = (most + 1) / 2)
        n_nodes *= 2;
    d->order = malloc(n * sizeof(*d->order));
    d->box = malloc(n_nodes * sizeof(*d->box));
    if (!d->order || !d->box) {
        dx_mesh_distance_fini(d);
        return -ENOMEM;
    }
    for (size_t t = 0; t < n; t++)
        d->order[t] = (uint32_t)t;
    build(d, 1, 0, n);
    return 0;
}

void dx_mesh_distance_fini(struct dx_mesh_distance *d)
{
    free(d->order);
    free(d->box);
    *d = (struct dx_mesh_distance){0};
}

static double box_distance2(const struct dx_distance_box *b, const double p[3])
{
    double sum = 0;

    for (int k = 0; k < 3; k++) {
        const double out = fmax(0, fmax(b->low[k] - p[k], p[k] - b->high[k]));

        sum += out * out;
    }
    return sum;
}

/* The least of `best` and what the node's triangles have. */
static double search(const struct dx_mesh_distance *d, size_t node, size_t start, size_t end,
                     const double p[3], double best)
{
    const size_t mid = start + (end - start) / 2;
    double near[2];

    if (end - start <= LEAF) {
        for (size_t k = start; k < end; k++) {
            const uint32_t t = d->order[k];

            best = fmin(
                best, dx_triangle_distance2(p, corner(d, t, 0), corner(d, t, 1), corner(d, t, 2)));
        }
        return best;
    }
    for (size_t k = 0; k < 2; k++)
        near[k] = box_distance2(&d->box[2 * node + k], p);
    for (size_t i = 0; i < 2; i++) {
        const size_t k = i ^ (near[1] < near[0]);

        if (near[k] < best)
            best = search(d, 2 * node + k, k ? mid : start, k ? end : mid, p, best);
    }
    return best;
}

double dx_mesh_distance_to(const struct dx_mesh_distance *d, const double p[3])
{
    return sqrt(search(d, 1, 0, d->n, p, INFINITY));
}
