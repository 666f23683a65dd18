/* What a cloud's parameters are found from. Any thread. */
#ifndef DX_SPACING_H
#define DX_SPACING_H

#include "core/cloud/cloud.h"

/* The median of the distance of the nearest neighbour over points spread through the cloud, steps;
 * at least 1. */
double dx_cloud_spacing(const struct dx_cloud *c);

#endif
