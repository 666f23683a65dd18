/* Many small sets of points to be ordered by angle: as dx_angle_sort, by counting first. Pure, any
 * thread. */
#ifndef DX_ANGLE_ORDER_H
#define DX_ANGLE_ORDER_H

#include "core/cloud/flat_order.h"

#define DX_ANGLE_ORDER_MAX 256

/* order[i]: which of at[n], n at most DX_ANGLE_ORDER_MAX and none of them the origin, is the i-th
 * by quadrant and angle; on one ray the nearer comes first, then that of the lower number. */
void dx_angle_order(uint8_t *order, const struct dx_flat *at, const uint32_t *number, uint32_t n);

#endif
