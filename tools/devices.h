/* The devices that the drivers of this build would take, for `dexel devices`. */
#ifndef DX_DEVICES_H
#define DX_DEVICES_H

#include "drivers/driver.h"

#include <jansson.h>
#include <stdio.h>

/*
 * Asks each driver of the list (NULL at its end) and prints what is attached: as YAML, a stream for
 * each device, what is known of it in comments; or as one JSON object. A driver that cannot tell is
 * named on standard error, and is the error that is returned, after all others were asked. 0 also
 * when nothing is attached.
 */
int dx_devices_print(FILE *out, const struct dx_driver *const *drivers, bool json);

/* The same as YAML for what a service has answered ({"devices":[...],"errors":[...]}): streams that
 * have a device open are named in its comment. */
int dx_devices_print_reply(FILE *out, const json_t *reply);

#endif
