/* Inside a capture: what its two files share. */
#ifndef DX_V4L2_CAPTURE_PRIV_H
#define DX_V4L2_CAPTURE_PRIV_H

#include "drivers/v4l2/v4l2_capture.h"

/* An ioctl, again when a signal cut it short. Negative errno. */
int dx_v4l2_call(const struct dx_v4l2_capture *c, unsigned long request, void *arg);

/* Makes an error of a call's: GONE of ENODEV, which the kernel says of a node whose device was
 * unplugged, whatever is asked of it. */
int dx_v4l2_failed(const struct dx_v4l2_capture *c, int code, const char *what, struct dx_err *err);

/* The kind of buffers: V4L2_BUF_TYPE_... */
uint32_t dx_v4l2_type(const struct dx_v4l2_capture *c);

/* Maps buffers for the shape that was settled. On error some may be mapped. */
int dx_v4l2_capture_map(struct dx_v4l2_capture *c, struct dx_err *err);

#endif
