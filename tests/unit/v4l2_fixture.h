/* For the tests of the V4L2 driver: a configuration, a sink that keeps the newest frame, blocks. */
#ifndef V4L2_FIXTURE_H
#define V4L2_FIXTURE_H

#include "drivers/v4l2/v4l2_block.h"

#include <stdlib.h>
#include <string.h>

struct v4l2_sink {
    struct dx_geometry *g;
    struct dx_plane plane;
    unsigned n_geometries, n_frames;
    bool closing;
    struct dx_frame_part part;
};

static inline int v4l2_sink_geometry(void *ctx, struct dx_geometry *g, uint8_t attr_bytes)
{
    struct v4l2_sink *s = ctx;

    dx_geometry_ref(g);
    dx_geometry_unref(s->g);
    dx_plane_fini(&s->plane);
    s->g = g;
    s->n_geometries++;
    return dx_plane_init_for(&s->plane, g, attr_bytes);
}

static inline struct dx_plane *v4l2_sink_plane(void *ctx, uint64_t number)
{
    struct v4l2_sink *s = ctx;

    (void)number;
    dx_plane_clear(&s->plane);
    return s->closing ? NULL : &s->plane;
}

static inline void v4l2_sink_deliver(void *ctx, const struct dx_frame_part *part)
{
    struct v4l2_sink *s = ctx;

    s->part = *part;
    s->n_frames++;
}

static inline struct dx_frame_sink v4l2_sink_of(struct v4l2_sink *s)
{
    return (struct dx_frame_sink){s, v4l2_sink_geometry, v4l2_sink_plane, v4l2_sink_deliver};
}

static inline void v4l2_sink_fini(struct v4l2_sink *s)
{
    dx_geometry_unref(s->g);
    dx_plane_fini(&s->plane);
}

/* What the configuration's defaults are, and a straight lens. */
static inline struct dx_v4l2_config v4l2_config(void)
{
    static char none[] = "";

    return (struct dx_v4l2_config){
        .path = none,
        .serial = none,
        .port = none,
        .unit_m = 0.001,
        .lens = {.fx = 100, .cx = DX_LENS_CENTRE, .cy = DX_LENS_CENTRE},
    };
}

/* The bytes of a block: a header, then `len` bytes of an image. The caller's to free. */
static inline uint8_t *v4l2_bytes(const struct dx_v4l2_header *h, const void *image, size_t len)
{
    uint8_t *bytes = malloc(DX_V4L2_HEADER_LEN + len);

    dx_v4l2_header_put(bytes, h);
    if (len)
        memcpy(bytes + DX_V4L2_HEADER_LEN, image, len);
    return bytes;
}

static inline struct dx_block v4l2_block(const uint8_t *bytes, size_t image_len)
{
    return (struct dx_block){.bytes = bytes,
                             .len = DX_V4L2_HEADER_LEN + image_len,
                             .stamp = {7, 5, DX_CLOCK_MONOTONIC},
                             .number = 3,
                             .source = "/dev/video9"};
}

#endif
