/*
 * Unorganized points, cleaned and indexed: the ground of the modes that mesh clouds. Points are
 * snapped to an integer lattice, so that all that decides topology is exact, and sorted into
 * dexels: square pixels of a plane, whose points are sorted by depth (Gopi and Krishnan 2002,
 * section 4). A point's number is its place in that order, its rank, and depends on the set of
 * points alone, not on their order in the input. Immutable once made; any thread may read.
 */
#ifndef DX_CLOUD_H
#define DX_CLOUD_H

#include "core/base/err.h"
#include "core/base/pool.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define DX_CLOUD_LATTICE    (1 << 28) /* the largest extent in steps, at most */
#define DX_CLOUD_MAX_POINTS ((size_t)1 << 30)
#define DX_CLOUD_MAX_ABS    1e150 /* of a coordinate */

struct dx_cloud {
    uint32_t n; /* points that are left, ranks 0 to n - 1 */
    uint32_t n_not_finite, n_duplicates;
    uint32_t n_strays; /* left out: so far that the lattice would not tell the others apart */
    /* Of the input, in this order: rows, columns and depth; a cyclic one, so that a cross product
     * of lattice vectors is one of the input's. Depth is where the cloud extends least. */
    int axis[3];
    double origin[3], step; /* coordinate axis[k] = origin[k] + step * at[][k] */
    int32_t (*at)[3];       /* [n] steps, 0 to DX_CLOUD_LATTICE */
    uint32_t *index;        /* [n] the point's number in the input, the lowest of its duplicates */
    uint32_t rows, cols;    /* dexels */
    int32_t side;           /* of a dexel, steps */
    int32_t low[2];         /* where the first row and column begin; what is before them or beyond
                               the last is in the outermost dexels */
    uint32_t *start;        /* [rows * cols + 1] ranks of dexel (i, j): from start[i * cols + j] */
};

/* A point near another. */
struct dx_near {
    int64_t d2; /* squared distance, steps */
    uint32_t rank;
};

/*
 * From xyz[n][3]. Points that are not finite, a few that are too far from the others, and all but
 * the first of those that fall on one lattice point, are left out and counted; that leaves none of
 * an empty cloud, which is no error. Errors: -EFBIG (too many points), -ERANGE (a coordinate beyond
 * DX_CLOUD_MAX_ABS), -ENOMEM; then *c is zeroed.
 */
int dx_cloud_init(struct dx_cloud *c, const double *xyz, size_t n, struct dx_pool *pool,
                  struct dx_err *err);
void dx_cloud_fini(struct dx_cloud *c);

/* Points within `radius` steps of lattice point p, in the order of rank by rows; at most `max` are
 * stored. Returns how many there are. */
uint32_t dx_cloud_within(const struct dx_cloud *c, const int32_t p[3], int32_t radius,
                         struct dx_near *out, uint32_t max);

#define DX_CLOUD_MAX_NEAREST 64

/* The k nearest to point `rank` (itself left out), k at most DX_CLOUD_MAX_NEAREST, by distance,
 * then rank. Returns their number: fewer only when the cloud has fewer. */
uint32_t dx_cloud_nearest(const struct dx_cloud *c, uint32_t rank, uint32_t k, struct dx_near *out);

#endif
