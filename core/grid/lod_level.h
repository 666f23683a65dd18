/* Which level of detail: what a subscriber asks for, in the numbers of the protocol. */
#ifndef DX_LOD_LEVEL_H
#define DX_LOD_LEVEL_H

#include <stdbool.h>
#include <stdint.h>

#define DX_LOD_PER_SIGMA  16 /* bounds and errors are in 1/16 sigma */
#define DX_LOD_MAX_BOUND  65534u
#define DX_LOD_MAX_STRIDE 64u

/* All zero: the whole mesh. */
struct dx_lod_level {
    uint16_t bound; /* 1/16 sigma; 0: errors do not count, where there is a stride */
    uint8_t stride; /* longest leg of a triangle, cells: 2, 4 .. 64; 0: 64 */
};

static inline bool dx_lod_is_whole(struct dx_lod_level level)
{
    return level.bound == 0 && level.stride == 0;
}

static inline bool dx_lod_same(struct dx_lod_level a, struct dx_lod_level b)
{
    return a.bound == b.bound && a.stride == b.stride;
}

/* NULL, or what is wrong with it. */
const char *dx_lod_check(struct dx_lod_level level);

/* NULL, or what is wrong; `sigmas` and `stride` 0: none. The bound is rounded to 1/16. */
const char *dx_lod_level_set(struct dx_lod_level *level, double sigmas, unsigned stride);

#endif
