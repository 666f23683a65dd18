/*
 * A whole file in memory, plain or gzip. The buffer is kept and reused for the next file. One
 * owner.
 */
#ifndef DX_SLURP_H
#define DX_SLURP_H

#include "core/base/err.h"

#include <stddef.h>
#include <stdint.h>

/* Bound on a file's (decompressed) size where the caller has no other. */
#define DX_SLURP_MAX ((size_t)4 << 30)

struct dx_slurp {
    uint8_t *bytes;
    size_t len, cap;
};

/* Replaces the contents by those of `path`. Errors: from open and read; -EINVAL (not a regular
 * file), -EFBIG (more than `max` bytes), -EBADMSG (damaged or truncated gzip), -ENOMEM; on an error
 * the contents are empty and err names the path. */
int dx_slurp_file(struct dx_slurp *s, const char *path, size_t max, struct dx_err *err);
void dx_slurp_fini(struct dx_slurp *s);

#endif
