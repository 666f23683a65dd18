/*
 * From organized points to a geometry: which of the three models describes the directions of a
 * frame of xyz, and how well. Called by readers of xyz formats (PTX, PCD), once a frame.
 */
#ifndef DX_FIT_H
#define DX_FIT_H

#include "core/base/err.h"
#include "core/grid/geometry.h"
#include "core/grid/plane.h"

#include <math.h>

/* Organized points, row-major, metres, scanner frame; a missing one is (NaN, NaN, NaN). */
struct dx_points {
    uint32_t height, width;
    const double *xyz;    /* [height * width * 3] */
    const uint16_t *attr; /* [height * width], or NULL */
    uint8_t attr_bytes;   /* of the plane to be made: 0, 1 or 2 */
};

/* A return: finite, not at the origin, and of a size whose square is safe. */
static inline bool dx_fit_valid(const double p[3])
{
    return fabs(p[0]) < 1e12 && fabs(p[1]) < 1e12 && fabs(p[2]) < 1e12 &&
           p[0] * p[0] + p[1] * p[1] + p[2] * p[2] > 1e-24;
}

struct dx_fit_options {
    double unit_m; /* 0: the finest 1-2-5 step that holds the largest range in 16 bits */
    int seam;      /* -1: from the data, 0 open, 1 closed */
};

struct dx_fit_report {
    double rms_dexel;                 /* residual of the chosen model, in dexels (0 for table) */
    double rms_spinning, rms_pinhole; /* of both; INFINITY where the model cannot hold the points */
    double regularity; /* rms departure of the fitted columns and rows from even steps, in dexels */
    double valid;      /* share of dexels with a return */
    double max_range_m;
    double azimuth_step_deg, elevation_step_deg; /* mean steps; pinhole: at the axis */
};

/*
 * Fits spinning (range from the origin, columns share an azimuth, rows an elevation; then also a
 * per-row azimuth offset) and pinhole (depth z), and takes the one whose rms residual is smaller
 * and below 0.1 dexel, else the table of the points' own directions (missing ones interpolated from
 * their neighbours). The result has unit, seam, handedness and range width set. Errors: -EINVAL
 * (sizes), -ENODATA (fewer than 16 valid points), -ENOMEM; text in err.
 */
int dx_fit_geometry(struct dx_geometry **out, struct dx_fit_report *report,
                    const struct dx_points *points, const struct dx_fit_options *options,
                    struct dx_err *err);

/* Ranges of the points under a geometry, rounded to its unit; a range that does not fit or is not
 * finite is left 0; and the points themselves where the plane has room for them. Returns how many
 * were dropped so. `plane` has the geometry's size and width. */
uint32_t dx_fit_ranges(struct dx_plane *plane, const struct dx_geometry *g,
                       const struct dx_points *points);

/* Every return lies within `dexels` of its dexel's direction and its range fits the unit: the
 * geometry of an earlier frame serves this one too. */
bool dx_fit_holds(const struct dx_geometry *g, const struct dx_points *points, double dexels);

#endif
