/* Publishing through the filters over frames. */
#include "tools/bench_ingest.h"

int dx_bench_ingest_init(struct dx_bench_ingest *b, enum dx_filter filter, struct dx_geometry *g,
                         const struct dx_terrain_params *params)
{
    struct dx_terrain_params p = *params;

    p.ingest.filter = filter;
    p.sigma_given = true; /* until the noise is known nothing is averaged */
    return dx_terrain_new(&b->terrain[filter], g, &p, 0);
}

void dx_bench_ingest_fini(struct dx_bench_ingest *b)
{
    for (int k = 0; k <= DX_FILTER_MEDIAN3; k++)
        dx_terrain_free(b->terrain[k]);
}

void dx_bench_ingest_run(struct dx_bench_ingest *b, enum dx_filter filter,
                         const struct dx_plane *frame, struct dx_pool *pool)
{
    dx_terrain_publish(b->terrain[filter], frame, 0, frame->width, pool);
}
