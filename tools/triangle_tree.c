/* Building the tree, by selection of the median. */
#include "tools/triangle_tree.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>

static double centre(const struct dx_triangle_tree *t, uint32_t k, int axis)
{
    return dx_tree_corner(t, k, 0)[axis] + dx_tree_corner(t, k, 1)[axis] +
           dx_tree_corner(t, k, 2)[axis];
}

static struct dx_tree_box box_of(const struct dx_triangle_tree *t, size_t start, size_t end)
{
    struct dx_tree_box b = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

    for (size_t k = start; k < end; k++)
        for (int c = 0; c < 3; c++)
            for (int axis = 0; axis < 3; axis++) {
                const double x = dx_tree_corner(t, t->order[k], c)[axis];

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
static void halve(struct dx_triangle_tree *t, size_t start, size_t mid, size_t end, int axis)
{
    while (end - start > 1) {
        const double pivot = centre(t, t->order[start + (end - start - 1) / 2], axis);
        size_t i = start, j = end - 1;

        for (;;) {
            while (centre(t, t->order[i], axis) < pivot)
                i++;
            while (centre(t, t->order[j], axis) > pivot)
                j--;
            if (i >= j)
                break;
            swap(&t->order[i++], &t->order[j--]);
        }
        if (mid <= j)
            end = j + 1;
        else
            start = j + 1;
    }
}

static void build(struct dx_triangle_tree *t, size_t node, size_t start, size_t end)
{
    const size_t mid = start + (end - start) / 2;
    const struct dx_tree_box b = box_of(t, start, end);
    int axis = 0;

    t->box[node] = b;
    if (end - start <= DX_TREE_LEAF)
        return;
    for (int k = 1; k < 3; k++)
        if (b.high[k] - b.low[k] > b.high[axis] - b.low[axis])
            axis = k;
    halve(t, start, mid, end, axis);
    build(t, 2 * node, start, mid);
    build(t, 2 * node + 1, mid, end);
}

int dx_triangle_tree_init(struct dx_triangle_tree *t, const double *xyz, const uint32_t *index,
                          size_t n)
{
    size_t n_nodes = 2;

    *t = (struct dx_triangle_tree){.xyz = xyz, .index = index, .n = n};
    if (n == 0 || n > (size_t)1 << 30)
        return -EINVAL;
    for (size_t most = n; most > DX_TREE_LEAF; most = (most + 1) / 2)
        n_nodes *= 2;
    t->order = malloc(n * sizeof(*t->order));
    t->box = malloc(n_nodes * sizeof(*t->box));
    if (!t->order || !t->box) {
        dx_triangle_tree_fini(t);
        return -ENOMEM;
    }
    for (size_t k = 0; k < n; k++)
        t->order[k] = (uint32_t)k;
    build(t, 1, 0, n);
    return 0;
}

void dx_triangle_tree_fini(struct dx_triangle_tree *t)
{
    free(t->order);
    free(t->box);
    *t = (struct dx_triangle_tree){0};
}
