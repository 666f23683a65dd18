/* Normals turned to one side: a part of dx_cloud_normals. */
#ifndef DX_ORIENT_H
#define DX_ORIENT_H

#include "core/cloud/neighbours.h"

/*
 * Turns n[][3], of unit length or zero, by a spanning forest of the graph of the first k of each
 * point's neighbours; n_parts gets the number of its trees that have a normal. Errors: -ENOMEM.
 */
int dx_orient(float (*n)[3], uint32_t *n_parts, const struct dx_cloud *cloud,
              const struct dx_neighbours *nb, uint32_t k, const double *viewpoint,
              struct dx_pool *pool);

#endif
