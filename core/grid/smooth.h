/*
 * Smoothing along the beam: from the array of samples to one with less noise (docs/terrain.md). A
 * pair of opposite neighbours tells what a dexel's inverse range is on any plane; the dexel takes
 * the robust mean of what the pairs around it tell and of its own sample. Only pairs that are
 * joined to it take part, and only ranges change: each sample stays in its dexel.
 *
 * A part (the dexels of a tile) follows from the samples within reach alone, whichever thread
 * computes it. Owned by one terrain; allocates when it is made and never after.
 */
#ifndef DX_SMOOTH_H
#define DX_SMOOTH_H

#include "core/grid/gates.h"
#include "core/grid/marks.h"
#include "core/rows/smoother.h"

#define DX_SMOOTH_MAX_MOVE 3 /* sigmas that a sample moves at most */

struct dx_smooth {
    struct dx_gates gates; /* those of the mesh, with the margin that smoothing needs */
    double noise;          /* of the samples: 1 for single ones, less for means */
    bool narrow;           /* 16-bit ranges: row_noise is sigma, for loops over rows */
    struct dx_smooth_noise row_noise;
    uint32_t reach;                    /* dexels around one that it depends on */
    struct dx_smooth_line *line;       /* [height][DX_SMOOTH_PAIRS]; even grids only */
    struct dx_smooth_scratch *scratch; /* one a thread of the pool */
};

/* `noise`: 1 sigma of what is smoothed, in sigmas of a sample. `uneven` as dx_gates.per_dexel.
 * Errors: -ENOMEM. */
int dx_smooth_init(struct dx_smooth *s, const struct dx_geometry *g, double noise, bool uneven);
void dx_smooth_fini(struct dx_smooth *s);

/* The constants that are in force; their arrays are shared and must outlive the smoothing. */
void dx_smooth_set(struct dx_smooth *s, const struct dx_gates *gates);

/* Smooths the dexels of a tile from `in` to `out` (planes of the grid; attributes are copied). In
 * `changed` lies all that now differs from what was in `out`; row0 > row1 where nothing does. */
void dx_smooth_part(struct dx_smooth *s, struct dx_plane *out, struct dx_rect *changed,
                    const struct dx_plane *in, const struct dx_tiling *tiling,
                    const struct dx_geometry *g, uint32_t tile, unsigned thread);

#endif
