/* What a status LED shows. Pure functions, any thread. */
#ifndef DX_LED_H
#define DX_LED_H

#include "drivers/rig.h"

#include <stdbool.h>
#include <stdint.h>

/* Is it lit at this time? *until_ns: when that may change (UINT64_MAX: it does not). */
bool dx_led_is_lit(enum dx_rig_show show, uint64_t now_ns, uint64_t *until_ns);

#endif
