/* How the samples of a dexel are made into one, in the figures of scenes that stand still. */
#ifndef DX_QUALITY_STATIC_H
#define DX_QUALITY_STATIC_H

#include "core/grid/terrain.h"

/* Turns the filter over frames on. Terrain mode has none yet: it publishes the newest sample. */
static inline void dx_quality_static_filter(struct dx_terrain_params *params)
{
    (void)params;
}

#endif
