/*
 * A rectangular plane of dexels: integer ranges in units of the stream's geometry, 0 = no return,
 * and one optional attribute a dexel (intensity). Row-major: dexel (row, col) is element row *
 * width + col; rows are elevations, columns azimuths, whichever way the device counts them. A frame
 * and the published array are both planes. Owned by one thread at a time.
 */
#ifndef DX_PLANE_H
#define DX_PLANE_H

#include <stddef.h>
#include <stdint.h>

struct dx_geometry;

/* Bounds for every grid from outside; a stencil that wraps must not meet itself (width >= 8 to
 * wrap). */
#define DX_PLANE_MAX_SIDE   65535u
#define DX_PLANE_MAX_DEXELS (1u << 28)

struct dx_plane {
    uint32_t height, width; /* rows, columns */
    uint8_t range_bytes;    /* 2 or 4 */
    uint8_t attr_bytes;     /* 0, 1 or 2 */
    void *range;            /* uint16_t or uint32_t [height * width] */
    void *attr;             /* uint8_t or uint16_t [height * width], NULL when attr_bytes is 0 */
    float *xyz;             /* [height * width * 3] where the stream is exact, else NULL: the points
                               themselves, scanner frame, metres; 0, 0, 0 where the range is 0 */
};

/* All dexels empty. Errors: -EINVAL (sizes out of bounds), -ENOMEM. */
int dx_plane_init(struct dx_plane *plane, uint32_t height, uint32_t width, uint8_t range_bytes,
                  uint8_t attr_bytes);
/* The plane of a stream: of its geometry's size and width, with points where it is exact. */
int dx_plane_init_for(struct dx_plane *plane, const struct dx_geometry *g, uint8_t attr_bytes);
void dx_plane_fini(struct dx_plane *plane);

/* All dexels empty again. */
void dx_plane_clear(struct dx_plane *plane);

static inline size_t dx_plane_n_dexels(const struct dx_plane *plane)
{
    return (size_t)plane->height * plane->width;
}

static inline uint32_t dx_plane_range(const struct dx_plane *plane, size_t k)
{
    return plane->range_bytes == 2 ? ((const uint16_t *)plane->range)[k]
                                   : ((const uint32_t *)plane->range)[k];
}

/* Ranges of n dexels from k on, and 0 for the rest of n_out. */
void dx_plane_get_ranges(const struct dx_plane *plane, size_t k, uint32_t n, uint32_t *out,
                         uint32_t n_out);
/* Ranges of n dexels from k on, that fit. */
void dx_plane_put_ranges(struct dx_plane *plane, size_t k, uint32_t n, const uint32_t *range);

static inline void dx_plane_set_range(struct dx_plane *plane, size_t k, uint32_t v)
{
    if (plane->range_bytes == 2)
        ((uint16_t *)plane->range)[k] = (uint16_t)v;
    else
        ((uint32_t *)plane->range)[k] = v;
}

static inline uint32_t dx_plane_attr(const struct dx_plane *plane, size_t k)
{
    if (plane->attr_bytes == 0)
        return 0;
    return plane->attr_bytes == 1 ? ((const uint8_t *)plane->attr)[k]
                                  : ((const uint16_t *)plane->attr)[k];
}

static inline void dx_plane_set_attr(struct dx_plane *plane, size_t k, uint32_t v)
{
    if (plane->attr_bytes == 1)
        ((uint8_t *)plane->attr)[k] = (uint8_t)v;
    else if (plane->attr_bytes == 2)
        ((uint16_t *)plane->attr)[k] = (uint16_t)v;
}

#endif
