/*
 * A cloud made thin: of each cluster one point, which Q takes from the centroid to the surface
 * (Mederos, Velho and de Figueiredo, section 2.3). Over the pool, the same bytes for any number of
 * threads.
 */
#ifndef DX_REDUCE_H
#define DX_REDUCE_H

#include "core/cloud/cluster.h"
#include "core/cloud/smooth_cloud.h"

struct dx_reduced {
    uint32_t n;
    double (*xyz)[3];   /* of the input's axes and unit, in the order of the clusters */
    float (*normal)[3]; /* the same axes, either side; 0 0 0: none */
    uint32_t n_medoids; /* members instead, because Q had no answer near */
    uint32_t n_merged;  /* points left out because another is next to them */
};

/* `scale`: of Q, for this cloud. Errors: -ENOMEM; then *out is zeroed. */
int dx_reduce(struct dx_reduced *out, const struct dx_cloud *cloud,
              const struct dx_clusters *clusters, const struct dx_cloud_smooth_scale *scale,
              struct dx_pool *pool, struct dx_err *err);
void dx_reduced_fini(struct dx_reduced *r);

#endif
