/*
 * Where frames come from for the tools: scan files, clouds in MCAP, or recordings of dexeld, which
 * the driver that made them decodes. All are drivers that take a struct dx_file_config and are read
 * to their end as fast as they go.
 */
#ifndef DX_SOURCE_H
#define DX_SOURCE_H

#include "drivers/file/file.h"

/* Of a path: dx_file_driver or dx_recorded_driver. */
const struct dx_driver *dx_source_driver(const char *path);

/* A recording has options of its own: 0, or -EINVAL having said that it takes none. */
int dx_source_check(const struct dx_file_config *config, const char *command);

/* When a block was there, ns: the log time of a recording, the stamp of a scan. */
uint64_t dx_source_time(const struct dx_driver *driver, const struct dx_block *block);

/* How the points lay in the geometry, NULL where there were none. */
const struct dx_fit_report *dx_source_fit_report(const struct dx_driver *driver,
                                                 const struct dx_device *dev);

/* ---- recordings ------------------------------------------------------------------------------
 */

/* Its blocks have the log time as their host stamp. A device says damaged things now and then: as
 * in the service those blocks are passed over, and standard error is told. */
extern const struct dx_driver dx_recorded_driver;

/* The driver that recorded, and its device. */
const struct dx_driver *dx_recorded_by(const struct dx_device *dev);
const char *dx_recorded_stream(const struct dx_device *dev);
const char *dx_recorded_config(const struct dx_device *dev, size_t *len);
/* Does the block that was read last start a frame? */
bool dx_recorded_starts_frame(const struct dx_device *dev);

#endif
