/*
 * Points for the modes that mesh clouds: those of a file of points or scans, or the returns of
 * frames that a driver reads: recordings, clouds in MCAP, folders and globs of scans. One thread.
 */
#ifndef DX_CLOUD_READ_H
#define DX_CLOUD_READ_H

#include "drivers/file/points.h"

#include <stdbool.h>

#define DX_CLOUD_READ_LAST UINT64_MAX
#define DX_CLOUD_READ_ALL  (UINT64_MAX - 1)

struct dx_cloud_source {
    const char *path;
    const char *topic; /* of clouds in MCAP; NULL: the only one */
    uint64_t frame;    /* from 0, or one of the above; not of a single file, of which all count */
};

/* The path is read frame by frame: `frame` and `topic` are of use. */
bool dx_cloud_source_has_frames(const char *path);

/* Replaces the list by the source's points, in the world's frame where it tells a pose. Errors:
 * -errno with text; then the list is empty. */
int dx_cloud_read(struct dx_point_list *list, const struct dx_cloud_source *source,
                  struct dx_err *err);

#endif
