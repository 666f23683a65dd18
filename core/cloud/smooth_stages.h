/*
 * Reconstruction from noise, stage by stage (Mederos, Velho and de Figueiredo, "Smooth Surface
 * Reconstruction from Noisy Clouds", 2004): smoothing, clusters, one point for each, a mesh of
 * those, its refinement to the smoothed points. Each stage takes what there is, so that a cloud can
 * be smoothed only, or thinned, or meshed as it is. Owned by one thread, which hands work to the
 * pool; the same bytes for any number of its threads.
 */
#ifndef DX_SMOOTH_STAGES_H
#define DX_SMOOTH_STAGES_H

#include "core/cloud/grow.h"
#include "core/cloud/reduce.h"
#include "core/cloud/refine.h"

struct dx_stages {
    struct dx_pool *pool;
    /* The points, without duplicates and those that are not finite, in the order of the input; in
     * its axes and unit. */
    uint32_t n, n_not_finite, n_duplicates;
    double (*xyz)[3];
    float (*normal)[3];             /* either side before dx_stages_orient; 0 0 0: none */
    struct dx_cloud cloud;          /* of them; index: their numbers here */
    struct dx_cloud_smooth_scale q; /* Q after smoothing; sw 0: not found yet */
    struct dx_clusters clusters;    /* of them, by rank */
    struct dx_reduced reduced;      /* n 0: none */
    struct dx_surface_mesh mesh;    /* of the reduced points, or of all; steps of `cloud` */
};

/* Copies xyz[n][3]. Errors: as dx_cloud_init. */
int dx_stages_init(struct dx_stages *s, const double *xyz, size_t n, struct dx_pool *pool,
                   struct dx_err *err);
void dx_stages_fini(struct dx_stages *s);

/* One pass; *scale is what it was done with. Errors: as dx_cloud_smooth_find, -ENOMEM. */
int dx_stages_smooth(struct dx_stages *s, struct dx_cloud_smooth_scale *scale,
                     struct dx_cloud_smooth_stats *stats,
                     const struct dx_cloud_smooth_config *config, struct dx_err *err);

int dx_stages_cluster(struct dx_stages *s, const struct dx_cluster_config *config,
                      struct dx_err *err);
/* After the clusters. */
int dx_stages_reduce(struct dx_stages *s, struct dx_err *err);
/* Of the reduced points, or of all when there are none. Vertices that several fans share are made
 * one for each, so that what comes out is a manifold. */
int dx_stages_grow(struct dx_stages *s, struct dx_grow_stats *stats,
                   const struct dx_grow_config *config, struct dx_err *err);
/* One pass, after the mesh. */
int dx_stages_refine(struct dx_stages *s, struct dx_refine_stats *stats,
                     const struct dx_refine_config *config, struct dx_err *err);

/* Turns the normals of the reduced points, or of all when there are none, to one side; those that
 * have none get that of their neighbours' plane. `viewpoint` [3], or NULL: the outside of what is
 * closed. Fewer than three points have none. Errors: -ENOMEM. */
int dx_stages_orient(struct dx_stages *s, const double *viewpoint, struct dx_err *err);

#endif
