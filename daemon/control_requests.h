/*
 * What may be asked on the control socket: one row of a table for each request, with the function
 * that answers it. Loop thread.
 */
#ifndef DX_CONTROL_REQUESTS_H
#define DX_CONTROL_REQUESTS_H

#include <jansson.h>
#include <stdint.h>
#include <sys/socket.h>

struct dx_server;

/* What takes longer than the loop may. */
enum dx_control_topic { DX_TOPIC_NONE, DX_TOPIC_RELOAD, DX_TOPIC_DEVICES };

/* Something that is under way, and which of those: they end in the order of their numbers. */
struct dx_control_wait {
    enum dx_control_topic topic; /* DX_TOPIC_NONE: nothing */
    uint64_t number;
};

/* The answer to `request`, a JSON value from a client: an object, with "error" when it is none of
 * those that are known or cannot be done. NULL: no memory; or, with wait->topic set, what was asked
 * for has begun, and dx_control_tell (control.h) answers it. What has changed something is in the
 * log, with `who` asked. */
json_t *dx_control_answer(struct dx_server *server, const json_t *request, const struct ucred *who,
                          struct dx_control_wait *wait);

#endif
