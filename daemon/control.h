/*
 * The control socket: one JSON object a line in, one a line out. {"request":"status"} is answered
 * as status.h says, what may be asked besides is in control_requests.c; anything else is answered
 * with {"error":"..."}. Loop thread.
 */
#ifndef DX_CONTROL_H
#define DX_CONTROL_H

#include <jansson.h>
#include <stdbool.h>

#include "core/base/err.h"
#include "daemon/control_requests.h"
#include "daemon/server.h"

struct dx_control;
struct dx_server;

/* *out is NULL when there is neither a path nor an inherited socket. Errors as dx_server_new. */
int dx_control_new(struct dx_control **out, struct dx_server *server, const char *path,
                   struct dx_err *err);
void dx_control_free(struct dx_control *c);

/* Answers the connections that wait for what is done now, or for what was to be before it. `reply`
 * stays the caller's. A NULL control is fine. */
void dx_control_tell(struct dx_control *c, struct dx_control_wait done, json_t *reply);

bool dx_control_is_inherited(const struct dx_control *c); /* NULL: no */
/* Where it listens; NULL: "none". */
void dx_control_path(const struct dx_control *c, char path[DX_SERVER_PATH]);

/* Accepts again, if it was out of descriptors; called once a second. NULL is fine. */
void dx_control_resume(struct dx_control *c);

#endif
