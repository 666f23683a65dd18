/*
 * Unorganized points with their normals as files that other programs read: PLY (nx, ny, nz), PCD
 * (normal_x, normal_y, normal_z, curvature), XYZ (six numbers a line). One thread.
 */
#ifndef DX_OUT_POINTS_H
#define DX_OUT_POINTS_H

#include "core/base/err.h"

#include <stdbool.h>
#include <stddef.h>

struct dx_out_points {
    size_t n;
    const double *xyz;        /* [n][3] */
    const float (*normal)[3]; /* [n], of unit length; zero where there is none */
    const float *curvature;   /* [n] share of the least eigenvalue, 0 to 1/3; NULL: 0 */
};

/* -EINVAL with text: the name ends in none of .ply, .pcd, .xyz. */
int dx_out_points_check(const char *path, struct dx_err *err);

/* In the form that the name tells; `ascii` is of PLY and PCD. Coordinates are floats where these
 * hold them to a part in 2^24 of the extent, and doubles where not. Errors: -EINVAL, -errno. */
int dx_out_points(const char *path, const struct dx_out_points *points, bool ascii,
                  struct dx_err *err);

#endif
