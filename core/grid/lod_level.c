/* Levels of detail: their range. */
#include "core/grid/lod_level.h"

#include <math.h>
#include <stddef.h>

static const char bad_stride[] = "a stride is 2, 4, 8, 16, 32 or 64";

const char *dx_lod_check(struct dx_lod_level level)
{
    if (level.bound > DX_LOD_MAX_BOUND)
        return "a bound is at most 65534 sixteenths of a sigma";
    if (level.stride &&
        (level.stride < 2 || level.stride > DX_LOD_MAX_STRIDE || level.stride & (level.stride - 1)))
        return bad_stride;
    return NULL;
}

const char *dx_lod_level_set(struct dx_lod_level *level, double sigmas, unsigned stride)
{
    const double bound = rint(sigmas * DX_LOD_PER_SIGMA);

    if (sigmas != 0 && !(bound >= 1 && bound <= DX_LOD_MAX_BOUND))
        return "a bound is from 1/16 to 4095 sigmas";
    if (stride > DX_LOD_MAX_STRIDE)
        return bad_stride;
    *level = (struct dx_lod_level){(uint16_t)bound, (uint8_t)stride};
    return dx_lod_check(*level);
}
