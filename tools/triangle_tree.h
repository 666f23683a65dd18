/*
 * The triangles of a mesh in a tree of boxes: a node halves its triangles by their centres along
 * its longest side. Coordinates and indices are the caller's and stay there. One thread builds;
 * then any may read.
 */
#ifndef DX_TRIANGLE_TREE_H
#define DX_TRIANGLE_TREE_H

#include <stddef.h>
#include <stdint.h>

#define DX_TREE_LEAF 4 /* triangles; a node of more has two children */

struct dx_tree_box {
    double low[3], high[3];
};

/* Node 1 has all of order[]; node k its part, from `start` to `end`; its children, 2 k and 2 k + 1,
 * what is before and from start + (end - start) / 2. */
struct dx_triangle_tree {
    const double *xyz;
    const uint32_t *index;
    uint32_t *order; /* triangles */
    struct dx_tree_box *box;
    size_t n;
};

/* Of n triangles, 1 to 2^30. Errors: -EINVAL, -ENOMEM; then *t is zeroed. */
int dx_triangle_tree_init(struct dx_triangle_tree *t, const double *xyz, const uint32_t *index,
                          size_t n);
void dx_triangle_tree_fini(struct dx_triangle_tree *t);

/* Corner k of a triangle: its three coordinates. */
static inline const double *dx_tree_corner(const struct dx_triangle_tree *t, uint32_t triangle,
                                           int k)
{
    return t->xyz + 3 * (size_t)t->index[3 * (size_t)triangle + (size_t)k];
}

#endif
