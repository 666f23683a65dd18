/*
 * Codes of the camera to depths: constants of the device, unpacking, a table of millimetres. A code
 * is a disparity in quarters of a pixel; the table is made once for each set of constants. Pure
 * functions, any thread; the same on every machine.
 */
#ifndef DX_KINECT_DEPTH_H
#define DX_KINECT_DEPTH_H

#include <stddef.h>
#include <stdint.h>

#define DX_KINECT_WIDTH   640u
#define DX_KINECT_HEIGHT  480u
#define DX_KINECT_PIXELS  (DX_KINECT_WIDTH * DX_KINECT_HEIGHT)
#define DX_KINECT_N_CODES 2048u

/* What a device knows of itself. */
struct dx_kinect_constants {
    float emitter_cm;   /* from the depth camera to the projector */
    float rcmos_cm;     /* to the colour camera */
    float reference_mm; /* of the reference plane */
    float pixel_mm;     /* size of a pixel there */
    uint16_t shift;
};

/* Bytes of a packed frame of 10 or 11 bits a code. */
static inline size_t dx_kinect_frame_len(int bits)
{
    return (size_t)DX_KINECT_PIXELS / 8 * (size_t)bits;
}

/* NULL, or the name of what no camera can have. */
const char *dx_kinect_constants_wrong(const struct dx_kinect_constants *c);

/* Millimetres of each code; 0: no return. Depths above max_mm are none. */
void dx_kinect_lut_fill(uint16_t lut[DX_KINECT_N_CODES], const struct dx_kinect_constants *c,
                        int bits, double max_mm);

/* n codes, a multiple of 8, each through the table; packed from the first byte's highest bit on. */
void dx_kinect_unpack(uint16_t *out, const uint8_t *packed, size_t n, int bits,
                      const uint16_t lut[DX_KINECT_N_CODES]);

/* Pixels of whose bits some lie in bytes [from, to) are set to 0. */
void dx_kinect_blank(uint16_t *out, size_t from, size_t to, int bits);

#endif
