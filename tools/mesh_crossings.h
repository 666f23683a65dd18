/*
 * Where a mesh goes through itself: pairs of triangles of which an edge of one passes through the
 * inside of the other. What only touches, by more than rounding can tell, is none. One thread.
 */
#ifndef DX_MESH_CROSSINGS_H
#define DX_MESH_CROSSINGS_H

#include <stddef.h>
#include <stdint.h>

struct dx_mesh_crossings {
    uint64_t n_pairs;
    uint32_t n_triangles; /* in some pair */
};

/* Of n triangles, 0 to 2^30; index[n][3] are places in xyz[][3]. Errors: -EINVAL, -ENOMEM. */
int dx_mesh_crossings_count(struct dx_mesh_crossings *c, const double *xyz, const uint32_t *index,
                            size_t n);

#endif
