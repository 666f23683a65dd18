/* Blocks of depth cameras from outside, two for one decoder: how it is configured (a byte), the
 * length of the first (2), the blocks. */
#include "core/base/bytes.h"
#include "drivers/v4l2/v4l2_decode.h"

#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len);

static int on_geometry(void *ctx, struct dx_geometry *g, uint8_t attr_bytes)
{
    struct dx_plane *plane = ctx;

    dx_plane_fini(plane);
    return dx_plane_init_for(plane, g, attr_bytes);
}

static struct dx_plane *on_plane(void *ctx, uint64_t number)
{
    struct dx_plane *plane = ctx;

    dx_plane_clear(plane);
    return number == UINT64_MAX ? NULL : plane;
}

static void on_deliver(void *ctx, const struct dx_frame_part *part)
{
    const struct dx_plane *plane = ctx;

    if (part->col0 + part->n_cols != plane->width)
        abort();
}

/* A copy of just that length, so that a read behind it is seen. */
static void decode(struct dx_v4l2_decoder *d, const struct dx_frame_sink *sink,
                   const uint8_t *bytes, size_t len)
{
    uint8_t *copy = malloc(len ? len : 1);
    const struct dx_block block = {.bytes = copy, .len = len, .source = "fuzz"};
    struct dx_err err;

    if (!copy)
        return;
    if (len)
        memcpy(copy, bytes, len);
    dx_v4l2_decode(d, &block, sink, &err);
    free(copy);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len)
{
    struct dx_v4l2_config c = {
        .lens = {.fx = 40, .cx = DX_LENS_CENTRE, .cy = DX_LENS_CENTRE},
    };
    struct dx_plane plane = {0};
    const struct dx_frame_sink sink = {&plane, on_geometry, on_plane, on_deliver};
    struct dx_v4l2_decoder d;
    size_t first;

    if (len < 3)
        return 0;
    c.lens.k1 = bytes[0] & 1 ? -0.05 : 0;
    c.lens.p2 = bytes[0] & 2 ? 0.01 : 0;
    c.min_m = bytes[0] & 4 ? 0.3 : 0;
    c.max_m = bytes[0] & 8 ? 4 : 0;
    first = dx_get_u16(bytes + 1);
    first = first < len - 3 ? first : len - 3;
    dx_v4l2_decoder_init(&d, &c);
    decode(&d, &sink, bytes + 3, first);
    decode(&d, &sink, bytes + 3 + first, len - 3 - first);
    dx_v4l2_decoder_fini(&d);
    dx_plane_fini(&plane);
    return 0;
}
