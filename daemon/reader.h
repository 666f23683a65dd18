/*
 * The reader of one stream: a thread that owns the opened device, reads raw blocks, and decodes
 * them into the mailbox. A source is opened once and ends; a device comes and goes
 * (reader_device.h). It never waits for a client, the mesher or the disk (save in a lossless
 * replay, at the mailbox).
 */
#ifndef DX_READER_H
#define DX_READER_H

#include "daemon/counters.h"
#include "daemon/heartbeat.h"
#include "daemon/mailbox.h"
#include "daemon/reader_device.h"
#include "daemon/recorder.h"
#include "drivers/driver.h"

struct dx_stream_reader;

/* Opens a source, so that a wrong path or name is told at once; of a device only what decodes.
 * Borrows all pointers. */
int dx_stream_reader_new(struct dx_stream_reader **out, const char *name,
                         const struct dx_driver *driver, const void *driver_config,
                         struct dx_mailbox *mailbox, struct dx_counters *counters,
                         struct dx_err *err);
/* Before it runs: who gets every raw block. Borrowed. */
void dx_stream_reader_record(struct dx_stream_reader *r, struct dx_recorder *recorder);
/* The same: its heartbeat, borrowed. */
void dx_stream_reader_watch(struct dx_stream_reader *r, struct dx_heartbeat *beat);
struct dx_device *dx_stream_reader_device(struct dx_stream_reader *r);
/* NULL: the source is no device, and has no subsystems. */
struct dx_reader_device *dx_stream_reader_attached(struct dx_stream_reader *r);
const char *const *dx_stream_reader_subsystems(const struct dx_stream_reader *r);
void dx_stream_reader_free(struct dx_stream_reader *r); /* closes the device */

/* The thread's body; returns when the source has ended, gone, or dx_stream_reader_stop was called.
 */
void dx_stream_reader_run(struct dx_stream_reader *r);
void dx_stream_reader_stop(struct dx_stream_reader *r); /* any thread; close the mailbox as well */

#endif
