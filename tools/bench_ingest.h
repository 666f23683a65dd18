/* Publishing through the filters over frames, for `dexel bench`: what it takes in place of the
 * stage that publishes frames as they are. */
#ifndef DX_BENCH_INGEST_H
#define DX_BENCH_INGEST_H

#include "core/grid/terrain.h"

/* Owns a terrain for each filter that is made. */
struct dx_bench_ingest {
    struct dx_terrain *terrain[DX_FILTER_MEDIAN3 + 1];
};

/* `params` say the noise. Errors: -ENOMEM; fini in any case. */
int dx_bench_ingest_init(struct dx_bench_ingest *b, enum dx_filter filter, struct dx_geometry *g,
                         const struct dx_terrain_params *params);
void dx_bench_ingest_fini(struct dx_bench_ingest *b);

void dx_bench_ingest_run(struct dx_bench_ingest *b, enum dx_filter filter,
                         const struct dx_plane *frame, struct dx_pool *pool);

#endif
