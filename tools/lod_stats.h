/*
 * What a level of detail is, in numbers: what it saves, how far the samples that it leaves out are
 * from it, and whether it has cracks. One thread.
 */
#ifndef DX_LOD_STATS_H
#define DX_LOD_STATS_H

#include "core/grid/lod.h"

struct dx_lod_stats {
    uint64_t triangles, whole; /* of the level, of the whole mesh; without caps */
    uint64_t left_out;         /* samples under larger triangles, vertices of the whole mesh */
    double max_sigma,
        rms_sigma;   /* of these, from the triangle that the beam meets, in sigmas in force */
    uint64_t cracks; /* edges of one triangle that are neither so in the whole mesh nor on the
                        border of the grid */
};

/* Of a terrain that was committed, and a level that is not the whole mesh. Errors: -ENOMEM. */
int dx_lod_stats_compute(struct dx_lod_stats *stats, const struct dx_terrain *t,
                         struct dx_lod_level level);

#endif
