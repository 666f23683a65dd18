/* Smoothing alone, for `dexel bench`: the stage that terrain mode runs inside its commit. */
#ifndef DX_BENCH_SMOOTH_H
#define DX_BENCH_SMOOTH_H

#include "core/grid/smoothing.h"

struct dx_bench_smooth {
    struct dx_gates gates;
    struct dx_tiling tiling;
    struct dx_smoothing *smoothing;
    struct dx_plane out;
};

/* With the noise of `params`. Errors: -ENOMEM. */
int dx_bench_smooth_init(struct dx_bench_smooth *b, const struct dx_geometry *g,
                         const struct dx_terrain_params *params);
void dx_bench_smooth_fini(struct dx_bench_smooth *b);

/* All parts of a frame. */
void dx_bench_smooth_run(struct dx_bench_smooth *b, const struct dx_plane *frame,
                         struct dx_pool *pool);

#endif
