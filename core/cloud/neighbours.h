/*
 * The k nearest neighbours of every point of a cloud: the graph on which normals are fitted and
 * turned to one side, and the first candidates of local triangulations. Made over the pool, the
 * same for any number of threads. Immutable once made; any thread may read.
 */
#ifndef DX_NEIGHBOURS_H
#define DX_NEIGHBOURS_H

#include "core/cloud/cloud.h"

struct dx_neighbours {
    uint32_t n;     /* points */
    uint32_t k;     /* of each; fewer than asked for only when the cloud has fewer others */
    uint32_t *rank; /* [n][k], by distance, then rank */
};

/* k: 1 to DX_CLOUD_MAX_NEAREST. Errors: -EINVAL, -ENOMEM; then *nb is zeroed. */
int dx_neighbours_init(struct dx_neighbours *nb, const struct dx_cloud *c, uint32_t k,
                       struct dx_pool *pool, struct dx_err *err);
void dx_neighbours_fini(struct dx_neighbours *nb);

static inline const uint32_t *dx_neighbours_of(const struct dx_neighbours *nb, uint32_t rank)
{
    return nb->rank + (size_t)rank * nb->k;
}

#endif
