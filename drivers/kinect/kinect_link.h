/*
 * Talking to a Kinect's camera over USB: commands and their replies. The device's thread.
 */
#ifndef DX_KINECT_LINK_H
#define DX_KINECT_LINK_H

#include "drivers/kinect/kinect_protocol.h"
#include "drivers/usb/usb_port.h"

#define DX_KINECT_VID         0x045e
#define DX_KINECT_PID_XBOX    0x02ae
#define DX_KINECT_PID_WINDOWS 0x02bf
#define DX_KINECT_ENDPOINT    0x82 /* depth, isochronous */

struct dx_kinect_link {
    struct dx_usb *usb;
    uint16_t tag;
    uint64_t due_ns; /* by then it must have answered, whatever is asked; 0: in its usual time */
    uint8_t reply[DX_KINECT_REPLY_LEN];
};

/* What the device knows of itself. As a driver's open(); -EPROTO: it answers what no camera does.
 */
int dx_kinect_link_constants(struct dx_kinect_link *link, struct dx_kinect_constants *c,
                             struct dx_err *err);
int dx_kinect_link_start(struct dx_kinect_link *link, int bits, struct dx_err *err);
int dx_kinect_link_stop(struct dx_kinect_link *link, struct dx_err *err);
int dx_kinect_link_near(struct dx_kinect_link *link, bool near, struct dx_err *err);

#endif
