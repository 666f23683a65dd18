/*
 * Smoothing an unorganized cloud by the robust operator Q (smooth_fit.h): each point goes to the
 * plane or paraboloid that fits the points around it, along its normal; all from the old cloud, so
 * that order and threads do not count. Where the parameters are not given they are found from the
 * data. Over the pool.
 */
#ifndef DX_SMOOTH_CLOUD_H
#define DX_SMOOTH_CLOUD_H

#include "core/cloud/cloud.h"

#include <stdbool.h>

#define DX_CLOUD_SMOOTH_MAX_PASSES 16

/* Of lengths in spacings: the side of the square that a point has of the surface. */
struct dx_cloud_smooth_config {
    double sw;    /* width of the weight by distance, 0.5 to 4; 0: found */
    double sr;    /* of the weight by height, 0.1 to 10; 0: found */
    bool quadric; /* paraboloids: less bias on what is curved, more noise for the same width */
};

/* What Q is applied with, found from a cloud or given. */
struct dx_cloud_smooth_scale {
    double spacing;   /* steps */
    double noise;     /* steps, standard deviation */
    double curvature; /* median of the mean curvature, 1 / spacings */
    double sw, sr;    /* spacings */
    bool quadric;
};

struct dx_cloud_smooth_stats {
    uint32_t n_unchanged; /* points with no plane around */
    uint32_t n_planes;    /* of quadric: points whose neighbours did not determine one */
    double mean_steps, mean_near;
    double rms_moved; /* steps */
};

/* Where Q takes a place, in steps of the cloud from its origin, and the normal there, either side.
 */
struct dx_cloud_smoothed {
    double at[3];
    float normal[3]; /* 0 0 0: none */
};

/* The side of a point's square from the distance of the 16th neighbour, a median over a sample;
 * steps, at least 1. Unlike the distance of the first it does not fall where points come in pairs.
 */
double dx_cloud_side(const struct dx_cloud *c);

/* Errors: -EINVAL (a parameter out of its range). */
int dx_cloud_smooth_find(struct dx_cloud_smooth_scale *scale, const struct dx_cloud *c,
                         const struct dx_cloud_smooth_config *config, struct dx_err *err);

/* out[c->n], by rank. */
void dx_cloud_smooth(struct dx_cloud_smoothed *out, struct dx_cloud_smooth_stats *stats,
                     const struct dx_cloud *c, const struct dx_cloud_smooth_scale *scale,
                     struct dx_pool *pool);

/* Q of a place that need not be a point of the cloud. Positive: the cloud has no plane there, *out
 * is the place itself, without a normal. */
enum { DX_CLOUD_SMOOTH_DONE = 0, DX_CLOUD_SMOOTH_UNCHANGED = 1 };
int dx_cloud_smooth_place(struct dx_cloud_smoothed *out, const struct dx_cloud *c,
                          const struct dx_cloud_smooth_scale *scale, const double at[3]);

/* In the input's axes and unit. */
void dx_cloud_to_input(double xyz[3], const struct dx_cloud *c, const double at[3]);

#endif
