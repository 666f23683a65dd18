/*
 * What may be asked on the control socket: one row of a table for each request, with the function
 * that answers it. Loop thread.
 */
#ifndef DX_CONTROL_REQUESTS_H
#define DX_CONTROL_REQUESTS_H

#include <jansson.h>
#include <stdint.h>

struct dx_server;

/* The answer to `request`, a JSON value from a client: an object, with "error" when it is none of
 * those that are known or cannot be done. NULL: no memory; or, with *later set, what was asked for
 * has begun, and dx_control_tell answers it with that number. */
json_t *dx_control_answer(struct dx_server *server, const json_t *request, uint64_t *later);

#endif
