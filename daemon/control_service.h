/*
 * Requests of the control socket about the service as a whole: {"request":"log-level"}, with
 * "level" to set it, and {"request":"quit"}. Loop thread.
 */
#ifndef DX_CONTROL_SERVICE_H
#define DX_CONTROL_SERVICE_H

#include <jansson.h>

struct dx_server;

/* {"level":NAME}, the one in force from now on; the configuration stays as it is. NULL: no memory.
 */
json_t *dx_control_log_level(struct dx_server *server, const json_t *request);
/* {}, and the end of the service. */
json_t *dx_control_quit(struct dx_server *server, const json_t *request);

#endif
