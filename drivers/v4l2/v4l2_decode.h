/*
 * The decoder of depth cameras: blocks to whole frames. Lives as long as the stream, over all stays
 * of a camera; used by the reader thread.
 */
#ifndef DX_V4L2_DECODE_H
#define DX_V4L2_DECODE_H

#include "drivers/v4l2/v4l2_block.h"

struct dx_v4l2_decoder {
    struct dx_lens lens;
    double min_m, max_m;
    bool told; /* the sink knows the geometry */
    struct dx_geometry *geometry;
    struct dx_v4l2_shape shape; /* what geometry and tables were made for */
    uint16_t lo, hi;            /* depths that count, in units */
    float *stretch;             /* [dexels] of a bent lens: range for a depth of 1; else NULL */
    float *depth;               /* [65536] of a disparity: units of a code, 0 none; else NULL */
    uint64_t frame;             /* of the next block */
    uint64_t n_beyond;          /* ranges that did not fit 16 bits */
};

void dx_v4l2_decoder_init(struct dx_v4l2_decoder *d, const struct dx_v4l2_config *config);
void dx_v4l2_decoder_fini(struct dx_v4l2_decoder *d);

/* Makes geometry and tables for a shape, where they are not those already. -EINVAL (the lens does
 * not fit, with text), -ENOMEM. */
int dx_v4l2_decoder_fit(struct dx_v4l2_decoder *d, const struct dx_v4l2_shape *shape,
                        struct dx_err *err);

/* As dx_driver's. */
int dx_v4l2_decode(struct dx_v4l2_decoder *d, const struct dx_block *block,
                   const struct dx_frame_sink *sink, struct dx_err *err);

#endif
