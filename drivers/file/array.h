/*
 * From the organized points of files to geometry and plane: in the points' own grid, as the fit
 * finds it, or thinned into an array of chosen size over the same field of view. The geometry of a
 * frame serves the following ones as long as their points lie in it. Owned by the reader thread.
 */
#ifndef DX_ARRAY_H
#define DX_ARRAY_H

#include "core/grid/fit.h"
#include "core/grid/represent.h"
#include "drivers/driver.h"

struct dx_array {
    struct dx_fit_options fit;
    struct dx_thin_options thin;
    bool exact;                     /* planes get the points themselves */
    struct dx_geometry *geometry;   /* told to the sink; NULL before */
    uint8_t attr_bytes;             /* told to the sink */
    struct dx_fit_report report;    /* of the points' own grid */
    struct dx_represent *represent; /* thinned: of `geometry` */
    uint32_t max_samples;           /* that it was made for */
    uint32_t *kept;                 /* thinned and exact: the sample that each dexel keeps */
};

void dx_array_fini(struct dx_array *a);

/* Do the options make an array? -EINVAL with text. */
int dx_array_check(const struct dx_thin_options *thin, bool exact, struct dx_err *err);

/* Keeps the geometry that was told, or tells the one of these points. 0; what the sink returned;
 * DX_DRIVER_E_CORRUPT (no geometry for these points), -ENOMEM with text, which names `source`. */
int dx_array_settle(struct dx_array *a, const struct dx_points *points, const double pose[12],
                    const char *source, const struct dx_frame_sink *sink, struct dx_err *err);

/* Takes a geometry as if it had settled on it: frames of before have told it. What the sink
 * returned. */
int dx_array_adopt(struct dx_array *a, struct dx_geometry *g, uint8_t attr_bytes,
                   const struct dx_frame_sink *sink);

/* The points that were settled last, into a plane of the geometry. */
void dx_array_fill(struct dx_array *a, struct dx_plane *plane, const struct dx_points *points);

#endif
