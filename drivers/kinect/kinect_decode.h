/*
 * Blocks of the Kinect driver to frames, for all stays of the device. Owned by the reader's thread.
 */
#ifndef DX_KINECT_DECODE_H
#define DX_KINECT_DECODE_H

#include "drivers/kinect/kinect.h"
#include "drivers/kinect/kinect_block.h"

struct dx_kinect_decoder {
    double max_m, fx, fy, cx, cy; /* as configured */
    uint64_t n_frames;
    /* Made from the constants of the newest block, and again when they change. */
    struct dx_geometry *geometry;
    struct dx_kinect_constants constants;
    int bits;
    uint16_t lut[DX_KINECT_N_CODES];
    bool told;
};

void dx_kinect_decoder_init(struct dx_kinect_decoder *d, const struct dx_kinect_config *config);
void dx_kinect_decoder_fini(struct dx_kinect_decoder *d);
/* As a driver's decode(). */
int dx_kinect_decode(struct dx_kinect_decoder *d, const struct dx_block *block,
                     const struct dx_frame_sink *sink, struct dx_err *err);

#endif
