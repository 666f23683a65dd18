/*
 * Files by their names, without waiting for anything but the disk: a FIFO in a folder of recordings
 * would otherwise hold whoever opens it until somebody writes to it. Any thread.
 */
#ifndef DX_OPEN_REGULAR_H
#define DX_OPEN_REGULAR_H

#include "core/base/err.h"

/* A descriptor to read from. Errors: from open; -EINVAL (not a regular file); err, which may be
 * NULL, names the path. */
int dx_open_regular(const char *path, struct dx_err *err);

#endif
