/*
 * The device half of a reader, for drivers of devices: opens it, reads it, closes it and looks for
 * it again, as the life cycle says, and tells subscribers, status and the log. The reader's thread
 * owns it; what other threads may call is marked.
 */
#ifndef DX_READER_DEVICE_H
#define DX_READER_DEVICE_H

#include "core/wire/wire.h"
#include "daemon/heartbeat.h"
#include "daemon/lifecycle.h"
#include "daemon/mailbox.h"
#include "drivers/driver.h"
#include "drivers/rig.h"

struct dx_reader_device;

/* The counts are of all stays. */
struct dx_reader_device_status {
    enum dx_life_state state;
    uint64_t since_ns;
    char reason[DX_WIRE_TEXT];      /* of a state that is not as it should be */
    struct dx_device_health health; /* of the last stay; its counts of all of them */
    uint64_t n_opens, n_stalls, n_faults, n_went;
};

/* Opens nothing. Borrows all pointers. */
int dx_reader_device_new(struct dx_reader_device **out, const char *name,
                         const struct dx_driver *driver, const void *driver_config,
                         struct dx_mailbox *mailbox, struct dx_err *err);
void dx_reader_device_free(struct dx_reader_device *d); /* closed by then */

/* Before the first turn: the GPIO lines of the stream, borrowed. It is told when the device is open
 * and how the stream is, and gives frames the stamps of their triggers. */
void dx_reader_device_rig(struct dx_reader_device *d, struct dx_rig *rig);
/* The same: the heartbeat of its thread, borrowed; NULL: nobody watches. */
void dx_reader_device_watch(struct dx_reader_device *d, struct dx_heartbeat *beat);
/* Any thread; NULL: it has none. */
struct dx_rig *dx_reader_device_lines(struct dx_reader_device *d);

/* The next turn: opens, reads or waits. 0: a block, numbered over all stays; AGAIN: none, ask
 * whether to stop. There is no end and no error. */
int dx_reader_device_read(struct dx_reader_device *d, struct dx_block *block);
bool dx_reader_device_streams(const struct dx_reader_device *d);
void dx_reader_device_close(struct dx_reader_device *d);

/* A line of this device, of which there may be a few in a minute; how many were left out is told
 * later. */
void dx_reader_device_log(struct dx_reader_device *d, int level, const char *text);

/* Any thread: ends a wait or a read. */
void dx_reader_device_wake(struct dx_reader_device *d);
/* Any thread: something has come, gone or changed where this device may be. */
void dx_reader_device_poke(struct dx_reader_device *d);
/* Any thread. */
void dx_reader_device_status(struct dx_reader_device *d, struct dx_reader_device_status *out);

#endif
