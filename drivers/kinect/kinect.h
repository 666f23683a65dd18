/*
 * The driver of Microsoft's Kinect of the first generation (Xbox 360, and Kinect for Windows v1):
 * its depth camera over libusb. docs/drivers/kinect.md. A block is a header with all constants
 * (kinect_block.h), then the packed codes of one frame as the camera sent them.
 */
#ifndef DX_KINECT_H
#define DX_KINECT_H

#include "drivers/driver.h"

struct dx_kinect_config {
    char *serial; /* of the USB device; "": any */
    char *port;   /* "1-2.3"; "": any */
    int bits;     /* 11 or 10, of a code */
    bool near;    /* near mode, of Kinect for Windows alone */
    double max_m; /* depths above are no return */
    /* Pixels; fx 0, fy 0: from the constants of the device, fy as fx; cx -1, cy -1: the middle. */
    double fx, fy, cx, cy;
    double tick_hz; /* of the device's clock; 0: measured against the host's */
};

extern const struct dx_driver dx_kinect_driver;

#endif
