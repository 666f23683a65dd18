/*
 * The files of a stream's recordings: names made of a pattern and the time, and how many bytes of
 * them stay. Owned by the recorder's thread.
 */
#ifndef DX_RECORD_FILES_H
#define DX_RECORD_FILES_H

#include "core/base/err.h"
#include "drivers/file/mcap.h"

#include <limits.h>

struct dx_record_files {
    const char *pattern; /* "/rec/hall-%Y%m%dT%H%M%S.mcap": strftime's Y m d H M S j F T and %% in
                            the name, not in its folder; the time is UTC */
    uint64_t keep_len;   /* bytes of all files of the pattern; 0: all stay */
    int fd;              /* -1: none is open */
    char path[PATH_MAX];
    char start[PATH_MAX]; /* of the newest name, without its number and extension */
    unsigned number;      /* of it; 0: there was none */
};

/* Is the pattern one? NULL, or why not ("found %q, ..."). */
const char *dx_record_files_check(const char *pattern);

void dx_record_files_init(struct dx_record_files *f, const char *pattern, uint64_t keep_len);
/* Makes a new file, and locks it: the name for time `unix_ns`; where one of that name has been,
 * with a number before ".mcap" (_0002, _0003 ...) above all that are there. So the order of the
 * names is that of the files, though the oldest are removed. Nothing that exists is written over.
 * Errors: from open. */
int dx_record_files_create(struct dx_record_files *f, uint64_t unix_ns);
/* Has what was written reached the disk? Errors: from fdatasync. */
int dx_record_files_sync(struct dx_record_files *f);
void dx_record_files_close(struct dx_record_files *f); /* none open is fine */
/* Removes the oldest ones until all fit into keep_len; never one that is being written, by
 * whomever. How many. */
unsigned dx_record_files_trim(const struct dx_record_files *f);

#endif
