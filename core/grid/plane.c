/* Allocation of dexel planes. */
#include "core/grid/geometry.h"
#include "core/grid/plane.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

int dx_plane_init(struct dx_plane *plane, uint32_t height, uint32_t width, uint8_t range_bytes,
                  uint8_t attr_bytes)
{
    size_t n = (size_t)height * width;

    *plane = (struct dx_plane){0};
    if (height == 0 || width == 0 || height > DX_PLANE_MAX_SIDE || width > DX_PLANE_MAX_SIDE ||
        n > DX_PLANE_MAX_DEXELS || (range_bytes != 2 && range_bytes != 4) || attr_bytes > 2)
        return -EINVAL;
    plane->height = height;
    plane->width = width;
    plane->range_bytes = range_bytes;
    plane->attr_bytes = attr_bytes;
    plane->range = calloc(n, range_bytes);
    plane->attr = attr_bytes ? calloc(n, attr_bytes) : NULL;
    if (!plane->range || (attr_bytes && !plane->attr)) {
        dx_plane_fini(plane);
        return -ENOMEM;
    }
    return 0;
}

int dx_plane_init_for(struct dx_plane *plane, const struct dx_geometry *g, uint8_t attr_bytes)
{
    int r = dx_plane_init(plane, g->height, g->width, g->range_bytes, attr_bytes);

    if (r < 0 || !g->exact)
        return r;
    plane->xyz = calloc(dx_plane_n_dexels(plane), 3 * sizeof(*plane->xyz));
    if (plane->xyz)
        return 0;
    dx_plane_fini(plane);
    return -ENOMEM;
}

void dx_plane_clear(struct dx_plane *plane)
{
    size_t n = dx_plane_n_dexels(plane);

    memset(plane->range, 0, n * plane->range_bytes);
    if (plane->attr)
        memset(plane->attr, 0, n * plane->attr_bytes);
    if (plane->xyz)
        memset(plane->xyz, 0, n * 3 * sizeof(*plane->xyz));
}

void dx_plane_fini(struct dx_plane *plane)
{
    free(plane->range);
    free(plane->attr);
    free(plane->xyz);
    *plane = (struct dx_plane){0};
}

void dx_plane_get_ranges(const struct dx_plane *plane, size_t k, uint32_t n, uint32_t *restrict out,
                         uint32_t n_out)
{
    const uint16_t *narrow = plane->range;

    if (plane->range_bytes == 4)
        memcpy(out, (const uint32_t *)plane->range + k, n * sizeof(*out));
    else
        for (uint32_t j = 0; j < n; j++)
            out[j] = narrow[k + j];
    memset(out + n, 0, (n_out - n) * sizeof(*out));
}

void dx_plane_put_ranges(struct dx_plane *plane, size_t k, uint32_t n,
                         const uint32_t *restrict range)
{
    uint16_t *narrow = plane->range;

    if (plane->range_bytes == 4)
        memcpy((uint32_t *)plane->range + k, range, n * sizeof(*range));
    else
        for (uint32_t j = 0; j < n; j++)
            narrow[k + j] = (uint16_t)range[j];
}
