/* The axis of least extent of a few points: the normal of the plane fitted to them. A pure
 * function, the same bits everywhere. */
#ifndef DX_LEAST_AXIS_H
#define DX_LEAST_AXIS_H

#include "core/cloud/sym3.h"

#include <stdbool.h>

/*
 * The unit eigenvector of the least eigenvalue of a covariance, and how much of the trace that
 * eigenvalue is. False: points on a line or in one place have no plane. Newton's iteration from 0
 * on the characteristic polynomial, which is all that points of a surface need; by rotations where
 * two eigenvalues are nearly equal.
 */
bool dx_least_axis(double axis[3], double *share, const struct dx_sym3 *covariance);

#endif
