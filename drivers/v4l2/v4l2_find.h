/* Which camera: by what the configuration says of it, never by its number. Any thread. */
#ifndef DX_V4L2_FIND_H
#define DX_V4L2_FIND_H

#include "drivers/udev.h"
#include "drivers/v4l2/v4l2.h"

/*
 * The camera that the configuration chooses; of its nodes the first that has the format. GONE: none
 * is attached, and err says what was looked for; -EINVAL: more than one, or none of the format;
 * -EACCES.
 */
int dx_v4l2_find(struct dx_udev_device *out, const struct dx_v4l2_config *config,
                 struct dx_err *err);

/* As dx_driver's. */
int dx_v4l2_probe(void (*found)(void *ctx, const struct dx_device_found *device), void *ctx,
                  struct dx_err *err);

#endif
