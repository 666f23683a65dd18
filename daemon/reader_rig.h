/*
 * Between a device's life and the GPIO lines about it (drivers/rig.h): what the lines are told and
 * what they tell. All of it does nothing without a rig (NULL). Reader thread.
 */
#ifndef DX_READER_RIG_H
#define DX_READER_RIG_H

#include "daemon/lifecycle.h"
#include "drivers/driver.h"
#include "drivers/rig.h"

/* The device is open and about to start; or it is closed. */
void dx_reader_rig_open(struct dx_rig *rig, const struct dx_driver *driver,
                        struct dx_device *device);
void dx_reader_rig_close(struct dx_rig *rig);

/* A block has come: its device stamp becomes that of its trigger's edge, if there is one. *n_lost
 * is kept from block to block of a stay: what the driver had lost by then. */
void dx_reader_rig_stamp(struct dx_rig *rig, const struct dx_driver *driver,
                         struct dx_device *device, uint64_t *n_lost, struct dx_block *block);

/* Trouble of the lines goes before the driver's own. */
void dx_reader_rig_trouble(struct dx_rig *rig, struct dx_device_health *health);

void dx_reader_rig_show(struct dx_rig *rig, enum dx_life_state state, bool has_trouble);

/* The interlock is open, or was a moment ago: that the device is silent is no fault. `text` says so
 * while it is open, else it becomes "". */
bool dx_reader_rig_holds(struct dx_rig *rig, uint64_t now_ns, char text[96]);

#endif
