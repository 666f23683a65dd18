/*
 * The driver of depth cameras that the kernel knows (Video4Linux): frames of depths or disparities,
 * streamed into mapped buffers. docs/drivers/v4l2.md. A block is a header (v4l2_block.h), then the
 * bytes of the camera's buffer as they are.
 */
#ifndef DX_V4L2_H
#define DX_V4L2_H

#include "drivers/driver.h"
#include "drivers/lens.h"

/* Pixel formats that can hold depth, by their names in the kernel. */
enum dx_v4l2_format {
    DX_V4L2_AUTO = 0, /* the first that says of itself that it is depth: Z16, INZI */
    DX_V4L2_Z16,
    DX_V4L2_INZI, /* infrared, then depth */
    DX_V4L2_Y16,
    DX_V4L2_Y16_BE,
    DX_V4L2_Y14,
    DX_V4L2_Y12,
    DX_V4L2_Y10,
    DX_V4L2_Y10B, /* packed: the depth of a Kinect by gspca_kinect */
    DX_V4L2_N_FORMATS
};

/* "Z16"; NULL past the last. */
const char *dx_v4l2_format_name(unsigned format);

struct dx_v4l2_config {
    /* Which camera: all that are not empty must agree. All empty: the only one. */
    char *path;   /* a node, or a link to it such as those in /dev/v4l/by-path */
    char *serial; /* of the USB device */
    char *port;   /* of the USB device: "1-2.3" */

    enum dx_v4l2_format format;
    uint32_t width, height; /* 0: as the camera has it */
    double fps;             /* 0: as the camera has it */

    double unit_m;       /* of a code; with a disparity: of the ranges made of it */
    double disparity[3]; /* [k, d0]: a code is k / (d0 - code) metres deep */
    bool disparity_given;
    uint32_t invalid;    /* a code of no return; 0 is one besides, where codes are depths */
    double min_m, max_m; /* depths that count; max 0: all */
    struct dx_lens lens;
};

extern const struct dx_driver dx_v4l2_driver;

#endif
