/*
 * Clusters of a cloud that are nearly flat, by halving: a cell of more than one piece is cut by the
 * plane through its centroid, across its longest axis (Pauly, Gross and Kobbelt 2002, whose tree
 * Mederos, Velho and de Figueiredo, section 2.2, take). A cluster can be represented by one point.
 * The same bytes for any number of threads. Immutable once made.
 */
#ifndef DX_CLUSTER_H
#define DX_CLUSTER_H

#include "core/cloud/cloud.h"

enum dx_cluster_split {
    DX_CLUSTER_ACROSS, /* the largest eigenvector is the plane's normal */
    DX_CLUSTER_FLAT,   /* the least, as the paper has it: above and below the sheet come apart */
};

struct dx_cluster_config {
    enum dx_cluster_split split;
    double max_variation; /* share of the least eigenvalue in their sum: more is cut */
    uint32_t min_points;  /* of a cluster that is cut for its variation: more than these */
    uint32_t max_points;  /* of a cluster; 0: any, the paper's rule */
};

struct dx_clusters {
    uint32_t n;
    uint32_t *start;  /* [n + 1] */
    uint32_t *member; /* [cloud->n] ranks; of cluster k from start[k], ascending */
};

void dx_cluster_defaults(struct dx_cluster_config *config);

/* Errors: -EINVAL (a parameter out of its range), -ENOMEM; then *c is zeroed. */
int dx_clusters_init(struct dx_clusters *c, const struct dx_cloud *cloud,
                     const struct dx_cluster_config *config, struct dx_pool *pool,
                     struct dx_err *err);
void dx_clusters_fini(struct dx_clusters *c);

#endif
