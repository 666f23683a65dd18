/* Distances of points to the nearest triangle of a mesh. Any thread. */
#ifndef DX_MESH_DISTANCE_H
#define DX_MESH_DISTANCE_H

#include "tools/triangle_tree.h"

double dx_mesh_distance_to(const struct dx_triangle_tree *t, const double p[3]);

/* The square of the distance of p to triangle abc, also where that has no area. */
double dx_triangle_distance2(const double p[3], const double a[3], const double b[3],
                             const double c[3]);

#endif
