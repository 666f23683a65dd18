/*
 * The picture that simulated depth cameras show: 16-bit depths of a bent, slanted surface with a
 * hole of zeros (no return), so gentle that all neighbours are joined. Its nearness to the camera
 * steps from frame to frame, by the frame's number: one value tells of which frame a picture is,
 * and whether all of it is of the same one.
 */
#ifndef HIL_DEPTH_PATTERN_H
#define HIL_DEPTH_PATTERN_H

#include <stdint.h>

#define DEPTH_PATTERN_STEPS 64u /* frames after which it repeats */

static inline uint16_t depth_pattern(uint32_t col, uint32_t row, uint64_t frame)
{
    if (col / 16 == 3 && row / 16 == 2)
        return 0;
    return (uint16_t)(1500 + col / 2 + row + (col * col) / 4096 + frame % DEPTH_PATTERN_STEPS);
}

#endif
