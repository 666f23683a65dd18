/* Smoothing alone. */
#include "tools/bench_smooth.h"

#include <string.h>

int dx_bench_smooth_init(struct dx_bench_smooth *b, const struct dx_geometry *g,
                         const struct dx_terrain_params *params)
{
    int rc = dx_plane_init(&b->out, g->height, g->width, g->range_bytes, 0);

    dx_tiling_init(&b->tiling, g->height, g->width, g->wrap);
    if (rc == 0)
        rc = dx_gates_init(&b->gates, g);
    if (rc == 0)
        rc = dx_smoothing_new(&b->smoothing, g, &b->tiling, &b->out, 1, b->gates.per_dexel);
    if (rc < 0)
        return rc;
    dx_gates_set(&b->gates, g, params);
    return 0;
}

void dx_bench_smooth_fini(struct dx_bench_smooth *b)
{
    dx_smoothing_free(b->smoothing);
    dx_gates_fini(&b->gates);
    dx_plane_fini(&b->out);
}

void dx_bench_smooth_run(struct dx_bench_smooth *b, const struct dx_plane *frame,
                         struct dx_pool *pool)
{
    memcpy(b->smoothing->sampled.range, frame->range,
           dx_plane_n_dexels(frame) * frame->range_bytes);
    dx_smoothing_set(b->smoothing, &b->gates); /* marks all parts */
    dx_smoothing_run(b->smoothing, &b->out, pool);
}
