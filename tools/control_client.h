/*
 * One question to a running dexeld on its control socket: a JSON object on a line each way. Owned
 * by one thread.
 */
#ifndef DX_CONTROL_CLIENT_H
#define DX_CONTROL_CLIENT_H

#include "core/base/err.h"

#include <jansson.h>

/*
 * The path to ask at, in `out`: `given` itself; "given.control" where that exists (then `given` is
 * a mesh socket); without `given` $DEXELD_CONTROL, else /run/dexeld/control.sock. -ENAMETOOLONG.
 */
int dx_control_path(char out[108], const char *given, struct dx_err *err);

/* Sends `request` and a newline, reads one line: malloc'ed, without its newline. Waits five seconds
 * at most. Errors: -errno, -ETIMEDOUT, -EMSGSIZE (a line above 16 MB), -ECONNRESET (no whole line),
 * -EPROTO (no JSON object). */
int dx_control_ask(char **reply, const char *path, const char *request, struct dx_err *err);

/* The same for what takes longer: waits so long for each part of the answer. `late` (NULL: nothing)
 * is a line for standard error when there is none of it after five seconds. */
int dx_control_ask_within(char **reply, const char *path, const char *request, int timeout_ms,
                          const char *late, struct dx_err *err);

/* What a line of answer says, the caller's. -EBADMSG: it is no object, or a refusal ("error"),
 * whose text is in err. */
int dx_control_take(json_t **reply, const char *line, const char *path, struct dx_err *err);

#endif
