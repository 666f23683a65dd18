/* The nearest triangle, by descending the tree's nearer half first. */
#include "tools/mesh_distance.h"

#include <math.h>

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

static double box_distance2(const struct dx_tree_box *b, const double p[3])
{
    double sum = 0;

    for (int k = 0; k < 3; k++) {
        const double out = fmax(0, fmax(b->low[k] - p[k], p[k] - b->high[k]));

        sum += out * out;
    }
    return sum;
}

/* The least of `best` and what the node's triangles have. */
static double search(const struct dx_triangle_tree *t, size_t node, size_t start, size_t end,
                     const double p[3], double best)
{
    const size_t mid = start + (end - start) / 2;
    double near[2];

    if (end - start <= DX_TREE_LEAF) {
        for (size_t k = start; k < end; k++) {
            const uint32_t at = t->order[k];

            best = fmin(best,
                        dx_triangle_distance2(p, dx_tree_corner(t, at, 0), dx_tree_corner(t, at, 1),
                                              dx_tree_corner(t, at, 2)));
        }
        return best;
    }
    for (size_t k = 0; k < 2; k++)
        near[k] = box_distance2(&t->box[2 * node + k], p);
    for (size_t i = 0; i < 2; i++) {
        const size_t k = i ^ (near[1] < near[0]);

        if (near[k] < best)
            best = search(t, 2 * node + k, k ? mid : start, k ? end : mid, p, best);
    }
    return best;
}

double dx_mesh_distance_to(const struct dx_triangle_tree *t, const double p[3])
{
    return sqrt(search(t, 1, 0, t->n, p, INFINITY));
}
