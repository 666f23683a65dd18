/*
 * The files that a source names: itself, the recordings of a directory, or what a glob matches; in
 * byte order of their names.
 */
#ifndef DX_FILE_LIST_H
#define DX_FILE_LIST_H

#include "core/base/err.h"

#include <stddef.h>

struct dx_file_list {
    char **paths;
    size_t n;
};

/* Errors: from stat, opendir and glob; -ENOENT also for a directory without recordings; -EINVAL for
 * what is neither file nor directory; -ENOMEM. */
int dx_file_list_init(struct dx_file_list *list, const char *path, struct dx_err *err);
/* Leaves out file `k`. */
void dx_file_list_remove(struct dx_file_list *list, size_t k);
void dx_file_list_fini(struct dx_file_list *list);

#endif
