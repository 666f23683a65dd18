/*
 * A file that appears whole or not at all: written under a temporary name beside its place, synced,
 * renamed. What is not a regular file (a pipe, /dev/stdout) is written in place. Owned by one
 * thread.
 */
#ifndef DX_OUT_FILE_H
#define DX_OUT_FILE_H

#include "core/base/err.h"

#include <stdio.h>

struct dx_out_file {
    FILE *stream;
    char *path, *temp; /* temp: NULL when written in place */
};

/* Errors: -errno, with the path in the text; *f is then zeroed. */
int dx_out_file_open(struct dx_out_file *f, const char *path, struct dx_err *err);

/* Ends the file: in its place, or, when anything failed since open (a full disk), gone. */
int dx_out_file_commit(struct dx_out_file *f, struct dx_err *err);

/* Takes it all back. A zeroed or committed file is fine. */
void dx_out_file_abort(struct dx_out_file *f);

#endif
