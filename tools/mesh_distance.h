/*
 * Distances of points to the nearest triangle of a mesh, by a tree of boxes. Coordinates and
 * indices are the caller's and stay there. One thread.
 */
#ifndef DX_MESH_DISTANCE_H
#define DX_MESH_DISTANCE_H

#include <stddef.h>
#include <stdint.h>

struct dx_distance_box {
    double low[3], high[3];
};

struct dx_mesh_distance {
    const double *xyz;
    const uint32_t *index;
    uint32_t *order;             /* triangles, halved by the tree */
    struct dx_distance_box *box; /* of node k, whose children are 2 k and 2 k + 1; from 1 */
    size_t n;
};

/* Of n triangles, 1 to 2^30. Errors: -EINVAL, -ENOMEM; then *d is zeroed. */
int dx_mesh_distance_init(struct dx_mesh_distance *d, const double *xyz, const uint32_t *index,
                          size_t n);
double dx_mesh_distance_to(const struct dx_mesh_distance *d, const double p[3]);
void dx_mesh_distance_fini(struct dx_mesh_distance *d);

/* The square of the distance of p to triangle abc, also where that has no area. */
double dx_triangle_distance2(const double p[3], const double a[3], const double b[3],
                             const double c[3]);

#endif
