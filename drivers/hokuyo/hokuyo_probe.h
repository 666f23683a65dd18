/* The scanners that are attached; a function of the driver's table. */
#ifndef DX_HOKUYO_PROBE_H
#define DX_HOKUYO_PROBE_H

#include "drivers/driver.h"

int dx_hokuyo_probe(void (*found)(void *ctx, const struct dx_device_found *device), void *ctx,
                    struct dx_err *err);

#endif
