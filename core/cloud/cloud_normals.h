/*
 * Normals of an unorganized cloud: of the plane fitted to a point and its nearest neighbours, all
 * turned to one side along a spanning tree of the neighbourhood graph that takes the smoothest
 * edges first (Hoppe et al. 1992, as Gopi 2000, section 5.1, has it). The same bytes for any number
 * of threads.
 */
#ifndef DX_CLOUD_NORMALS_H
#define DX_CLOUD_NORMALS_H

#include "core/cloud/cloud.h"
#include "core/cloud/neighbours.h"

struct dx_cloud_normals_config {
    uint32_t k;              /* neighbours of a fit: 2 to DX_CLOUD_MAX_NEAREST */
    const double *viewpoint; /* [3], of the input: most normals of each part face it. NULL: the
                                highest point's faces up, so closed surfaces get their outside */
};

struct dx_cloud_normals_stats {
    uint32_t n_parts;     /* that no edge of the graph joins; each has a side of its own */
    uint32_t n_undefined; /* points with neighbours on one line */
};

void dx_cloud_normals_defaults(struct dx_cloud_normals_config *config);

/*
 * Fills n[cloud->n][3] by rank: unit vectors in the cloud's axes, zero where there is none. `nb`
 * may be the cloud's neighbours, at least config->k of each if there are so many, or NULL.
 * `variation`, [n] or NULL, gets the share of the least eigenvalue in their sum. Errors: -EINVAL,
 * -ENOMEM.
 */
int dx_cloud_normals(float (*n)[3], float *variation, struct dx_cloud_normals_stats *stats,
                     const struct dx_cloud *cloud, const struct dx_neighbours *nb,
                     const struct dx_cloud_normals_config *config, struct dx_pool *pool,
                     struct dx_err *err);

/* A normal in the axes of the input. */
static inline void dx_cloud_normal_out(float out[3], const struct dx_cloud *c, const float n[3])
{
    for (int k = 0; k < 3; k++)
        out[c->axis[k]] = n[k];
}

#endif
