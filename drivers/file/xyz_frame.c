/* The organized points that formats decode into: memory and intensity scale. */
#include "drivers/file/format.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

int dx_xyz_frame_reserve(struct dx_xyz_frame *f, uint32_t height, uint32_t width)
{
    size_t n = (size_t)height * width;

    if (n > f->cap_dexels) {
        dx_xyz_frame_fini(f);
        f->xyz = malloc(n * 3 * sizeof(*f->xyz));
        f->attr_room = malloc(n * sizeof(*f->attr_room));
        f->intensity = malloc(n * sizeof(*f->intensity));
        if (!f->xyz || !f->attr_room || !f->intensity) {
            dx_xyz_frame_fini(f);
            return -ENOMEM;
        }
        f->cap_dexels = n;
    }
    f->height = height;
    f->width = width;
    f->attr = NULL;
    f->attr_bytes = 0;
    memcpy(f->pose, identity, sizeof(identity));
    for (size_t k = 0; k < 3 * n; k++)
        f->xyz[k] = NAN;
    return 0;
}

void dx_xyz_frame_fini(struct dx_xyz_frame *f)
{
    free(f->xyz);
    free(f->attr_room);
    free(f->intensity);
    *f = (struct dx_xyz_frame){0};
}

/* To a whole number, as rint() does: so that the loop becomes vectors. */
#define WHOLE 0x1p52

/* Smallest and largest intensity of the returns. */
static void extent(const struct dx_xyz_frame *f, double *min, double *max)
{
    size_t n = (size_t)f->height * f->width;

    *min = INFINITY;
    *max = -INFINITY;
    for (size_t k = 0; k < n; k++) {
        double v = (double)f->intensity[k];

        if (isnan(f->xyz[3 * k]) || !isfinite(v))
            continue;
        *min = v < *min ? v : *min;
        *max = v > *max ? v : *max;
    }
}

void dx_xyz_frame_scale(struct dx_xyz_frame *f)
{
    size_t n = (size_t)f->height * f->width;
    double min, max, from = 0, scale;

    extent(f, &min, &max);
    if (min >= 0 && max <= 65535) {
        scale = max <= 1 ? 65535 : max <= 255 ? 257 : 1;
    } else {
        from = min;
        scale = max > min ? 65535 / (max - min) : 0;
    }
    f->attr = f->attr_room;
    f->attr_bytes = 2;
    for (size_t k = 0; k < n; k++) {
        double v = ((double)f->intensity[k] - from) * scale;

        v = v > 0 ? v : 0; /* no number as well */
        v = v < 65535 ? v : 65535;
        f->attr[k] = (uint16_t)(int32_t)(v + WHOLE - WHOLE);
    }
}
