/*
 * Many samples into a chosen array: which one stands for a dexel when several samples of one frame
 * fall into it (ALGORITHMS 1.9, D5). Samples come in batches, in any order; the choice depends on
 * the samples and their numbers alone. All memory is taken when it is made. One owner.
 */
#ifndef DX_REPRESENT_H
#define DX_REPRESENT_H

#include "core/grid/geometry.h"
#include "core/grid/plane.h"

enum dx_keep {
    DX_KEEP_CENTRE,  /* the one nearest to the dexel's axis; ties: the smaller number */
    DX_KEEP_NEAREST, /* the shortest range; ties: the smaller number */
    DX_KEEP_MEDIAN,  /* the lower median of the ranges; an input sample too */
    DX_KEEP_MEAN,  /* the mean of the ranges, rounded: no input sample, and at steps none at all */
    DX_KEEP_FIRST, /* the smallest number */
    DX_N_KEEP,
};

/* Why exact points cannot be had with it. */
#define DX_EXACT_NO_MEAN "exact points need a sample that is kept, found keep mean"

const char *dx_keep_name(unsigned keep); /* NULL past the last */

/* The array that a frame is thinned into; width 0: the frame's own grid, nothing is thinned. */
struct dx_thin_options {
    uint32_t width, height;
    enum dx_keep keep;
};

/* Points in the scanner's frame, metres; of the two arrays one, the other NULL. */
struct dx_samples {
    size_t n;
    const double *xyz;    /* [3 * n] */
    const float *xyz32;   /* [3 * n] */
    const uint16_t *attr; /* [n], or NULL */
    uint32_t number;      /* of the first one; each has its own within the frame */
};

struct dx_represent_counts {
    uint64_t taken;
    uint64_t missing; /* not finite, or at the origin */
    uint64_t outside; /* the field of view */
    uint64_t unfit;   /* a range that the geometry's unit and width cannot hold */
};

struct dx_represent;

/*
 * For a spinning or pinhole geometry (lookup.h). Numbers are below `max_samples`; the median keeps
 * so many samples (16 bytes each), the others one entry of 16 to 24 bytes a dexel. Takes a
 * reference on `g`. Errors: -EINVAL, -ENOMEM.
 */
int dx_represent_new(struct dx_represent **out, struct dx_geometry *g, enum dx_keep keep,
                     uint32_t max_samples);
void dx_represent_free(struct dx_represent *r);

/* Empties the array for the next frame. */
void dx_represent_reset(struct dx_represent *r);

/* Errors: -ERANGE, more samples than were announced; none of the batch is taken then. */
int dx_represent_add(struct dx_represent *r, const struct dx_samples *s);

/* Once a frame, after its last batch: the plane, which has the geometry's size and width, and where
 * asked for the number of the sample that each dexel keeps, UINT32_MAX where there is none (and
 * everywhere for the mean). */
void dx_represent_finish(struct dx_represent *r, struct dx_plane *plane, uint32_t *kept);

/* Since the reset. */
const struct dx_represent_counts *dx_represent_counts(const struct dx_represent *r);

#endif
