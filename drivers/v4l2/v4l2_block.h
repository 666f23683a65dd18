/*
 * Blocks of the V4L2 driver: a header of 64 bytes, little-endian, then the bytes of a buffer.
 *
 *   0 "DXV4"   4 u16 version, u16 length of the header   8 u32 pixel format (V4L2's code)
 *  12 u32 width, u32 height, u32 bytes a line            24 u32 where the image begins in the bytes
 *  28 u32 sequence, u32 flags (V4L2's)                   36 u32 code of no return
 *  40 f64 metres a unit                                  48 f64 k, f64 d0 of a disparity; k 0: none
 *
 * Pure functions, any thread.
 */
#ifndef DX_V4L2_BLOCK_H
#define DX_V4L2_BLOCK_H

#include "drivers/v4l2/v4l2.h"

#define DX_V4L2_HEADER_LEN 64
#define DX_V4L2_MIN_UNIT   1e-6
#define DX_V4L2_MAX_UNIT   1.0

/* What codes there are, and what they mean. */
struct dx_v4l2_shape {
    enum dx_v4l2_format format;
    uint32_t width, height, bytesperline;
    uint32_t invalid;
    double unit_m, k, d0;
};

struct dx_v4l2_header {
    struct dx_v4l2_shape shape;
    uint32_t data_offset, sequence, flags;
};

/* Where the depths of an image lie. */
struct dx_v4l2_layout {
    size_t at;     /* of the first row */
    size_t stride; /* from row to row */
    size_t end;    /* behind the last byte that is needed */
};

uint32_t dx_v4l2_format_fourcc(enum dx_v4l2_format format);
/* AUTO: none of ours. */
enum dx_v4l2_format dx_v4l2_format_find(uint32_t fourcc);
unsigned dx_v4l2_format_bits(enum dx_v4l2_format format);

/* -EINVAL: no image has this shape; `why` says so ("line of 1000 bytes, expected 1280 or more"). */
int dx_v4l2_layout(struct dx_v4l2_layout *out, const struct dx_v4l2_shape *shape, char why[96]);

void dx_v4l2_header_put(uint8_t bytes[DX_V4L2_HEADER_LEN], const struct dx_v4l2_header *h);
/* Checks all that the header and the length say. 0, or DX_DRIVER_E_CORRUPT with err. */
int dx_v4l2_header_get(struct dx_v4l2_header *h, struct dx_v4l2_layout *layout,
                       const struct dx_block *block, struct dx_err *err);

#endif
