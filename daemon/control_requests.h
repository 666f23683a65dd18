/*
 * What may be asked on the control socket: one row of a table for each request, with the function
 * that answers it. Loop thread.
 */
#ifndef DX_CONTROL_REQUESTS_H
#define DX_CONTROL_REQUESTS_H

#include <jansson.h>
#include <sys/socket.h>

struct dx_server;

/* The answer to `request`, a JSON value from a client: an object, with "error" when it is none of
 * those that are known or cannot be done. A JSON null: dx_control_reply (control.h) brings it, in a
 * moment. NULL: no memory. What has changed something is in the log, with `who` asked. */
json_t *dx_control_answer(struct dx_server *server, const json_t *request, const struct ucred *who);

#endif
