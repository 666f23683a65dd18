/* Repair of recordings, for `dexel convert --repair`. */
#ifndef DX_REPAIR_H
#define DX_REPAIR_H

#include "core/base/err.h"

/* Writes what can be read of the MCAP file `in` to `out`, and says on standard error (as `command`)
 * what was damaged and what was saved. Errors: -errno, text in err. */
int dx_repair_file(const char *in, const char *out, const char *command, struct dx_err *err);

#endif
