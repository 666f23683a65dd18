/*
 * Blocks of the Kinect driver: a header of 96 bytes, little-endian, then a packed frame.
 *
 *   0 "DXKN"              4 u16 version, u16 length of the header
 *   8 u8 bits of a code   9 u8 product: 0 Xbox, 1 Windows   10 u8 near, u8 0
 *  12 u16 width, u16 height
 *  16 f32 distance of the projector (cm), of the colour camera (cm), reference distance (mm), size
 * of a pixel there (mm)  32 u16 shift, u16 0 36 u32 ticks of the device, u32 packets that this
 * frame lacks 44 u32 frames lost, u32 frames damaged, so far in this stay 52 u8[32] which packets
 * it lacks: bit k % 8 of byte k / 8  84 zeros
 *
 * Pure functions, any thread.
 */
#ifndef DX_KINECT_BLOCK_H
#define DX_KINECT_BLOCK_H

#include "drivers/driver.h"
#include "drivers/kinect/kinect_depth.h"
#include "drivers/kinect/kinect_packets.h"

#define DX_KINECT_HEADER_LEN 96

struct dx_kinect_header {
    int bits;
    bool windows, near;
    struct dx_kinect_constants constants;
    uint32_t ticks, n_lost;
    uint32_t n_frames_lost, n_frames_damaged;
    uint8_t lost[DX_KINECT_MAX_PACKETS / 8];
};

void dx_kinect_header_put(uint8_t bytes[DX_KINECT_HEADER_LEN], const struct dx_kinect_header *h);
/* Checks all that the header and the length say. 0, or DX_DRIVER_E_CORRUPT with err. */
int dx_kinect_header_get(struct dx_kinect_header *h, const struct dx_block *block,
                         struct dx_err *err);

#endif
