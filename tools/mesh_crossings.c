/* Each triangle's box against the tree of all; pairs whose boxes meet by the signs of volumes. */
#include "tools/mesh_crossings.h"

#include "tools/triangle_tree.h"

#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#define ROUNDING 1e-14 /* of a volume, by the sum of its terms: 16 operations of 2^-53 and some */

struct search {
    struct dx_triangle_tree tree;
    uint8_t *crossed; /* [n] */
    uint64_t n_pairs;
};

/* The side of plane abc that p is on; 0: rounding does not tell. */
static int side(const double a[3], const double b[3], const double c[3], const double p[3])
{
    double u[3], v[3], w[3], sum = 0, size = 0;

    for (int k = 0; k < 3; k++) {
        u[k] = b[k] - a[k];
        v[k] = c[k] - a[k];
        w[k] = p[k] - a[k];
    }
    for (int k = 0; k < 3; k++) {
        const double x = u[(k + 1) % 3] * v[(k + 2) % 3], y = u[(k + 2) % 3] * v[(k + 1) % 3];

        sum += (x - y) * w[k];
        size += (fabs(x) + fabs(y)) * fabs(w[k]);
    }
    return fabs(sum) <= ROUNDING * size ? 0 : sum > 0 ? 1 : -1;
}

static bool passes(const double p[3], const double q[3], const double *const v[3])
{
    const int from = side(v[0], v[1], v[2], p), to = side(v[0], v[1], v[2], q);
    int turn;

    if (from * to >= 0)
        return false;
    turn = side(p, q, v[0], v[1]);
    return turn && side(p, q, v[1], v[2]) == turn && side(p, q, v[2], v[0]) == turn;
}

/* An edge of triangle s goes through triangle t; edges from a corner of t do not. */
static bool pierces(const struct dx_triangle_tree *tree, uint32_t s, uint32_t t)
{
    const uint32_t *of_s = tree->index + 3 * (size_t)s, *of_t = tree->index + 3 * (size_t)t;
    const double *const v[3] = {dx_tree_corner(tree, t, 0), dx_tree_corner(tree, t, 1),
                                dx_tree_corner(tree, t, 2)};
    bool shared[3];

    for (int k = 0; k < 3; k++)
        shared[k] = of_s[k] == of_t[0] || of_s[k] == of_t[1] || of_s[k] == of_t[2];
    for (int k = 0; k < 3; k++) {
        const int next = (k + 1) % 3;

        if (!shared[k] && !shared[next] &&
            passes(dx_tree_corner(tree, s, k), dx_tree_corner(tree, s, next), v))
            return true;
    }
    return false;
}

static struct dx_tree_box box_of(const struct dx_triangle_tree *tree, uint32_t t)
{
    struct dx_tree_box b;

    for (int axis = 0; axis < 3; axis++) {
        const double x = dx_tree_corner(tree, t, 0)[axis], y = dx_tree_corner(tree, t, 1)[axis],
                     z = dx_tree_corner(tree, t, 2)[axis];

        b.low[axis] = fmin(x, fmin(y, z));
        b.high[axis] = fmax(x, fmax(y, z));
    }
    return b;
}

static bool meet(const struct dx_tree_box *a, const struct dx_tree_box *b)
{
    for (int axis = 0; axis < 3; axis++)
        if (!(a->low[axis] <= b->high[axis] && b->low[axis] <= a->high[axis]))
            return false;
    return true;
}

/* Pairs of triangle t with those of higher number below the node. */
static void descend(struct search *s, uint32_t t, const struct dx_tree_box *box, size_t node,
                    size_t start, size_t end)
{
    const size_t mid = start + (end - start) / 2;

    if (!meet(box, &s->tree.box[node]))
        return;
    if (end - start > DX_TREE_LEAF) {
        descend(s, t, box, 2 * node, start, mid);
        descend(s, t, box, 2 * node + 1, mid, end);
        return;
    }
    for (size_t k = start; k < end; k++) {
        const uint32_t other = s->tree.order[k];
        const struct dx_tree_box its = box_of(&s->tree, other);

        if (other <= t || !meet(box, &its) ||
            !(pierces(&s->tree, t, other) || pierces(&s->tree, other, t)))
            continue;
        s->crossed[t] = s->crossed[other] = 1;
        s->n_pairs++;
    }
}

int dx_mesh_crossings_count(struct dx_mesh_crossings *c, const double *xyz, const uint32_t *index,
                            size_t n)
{
    struct search s = {.crossed = calloc(n + 1, 1)};
    int rc = s.crossed ? 0 : -ENOMEM;

    *c = (struct dx_mesh_crossings){0};
    if (rc == 0 && n)
        rc = dx_triangle_tree_init(&s.tree, xyz, index, n);
    for (size_t t = 0; rc == 0 && t < n; t++) {
        const struct dx_tree_box box = box_of(&s.tree, (uint32_t)t);

        descend(&s, (uint32_t)t, &box, 1, 0, n);
    }
    for (size_t t = 0; rc == 0 && t < n; t++)
        c->n_triangles += s.crossed[t];
    c->n_pairs = s.n_pairs;
    dx_triangle_tree_fini(&s.tree);
    free(s.crossed);
    return rc;
}
