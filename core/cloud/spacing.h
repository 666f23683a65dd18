/* What the parameters of a mesh are found from: measures of a cloud, over a sample of its points
 * spread through the cloud. Any thread. */
#ifndef DX_SPACING_H
#define DX_SPACING_H

#include "core/cloud/cloud.h"

/* The median of the distance of the nearest neighbour, steps; at least 1. */
double dx_cloud_spacing(const struct dx_cloud *c);

/* The median of what is left of the heights of the nearest 20 points over a paraboloid fitted to
 * them, as a standard deviation, steps: noise, and what is sharper than the sampling. 0 for fewer
 * than 21 points. */
double dx_cloud_noise(const struct dx_cloud *c);

#endif
