/*
 * `dexel reload` and `dexel config`: one request to a running dexeld as a whole, and its answer for
 * people or as JSON.
 */
#ifndef DX_SERVICE_REQUEST_H
#define DX_SERVICE_REQUEST_H

#include <jansson.h>

#include "core/base/err.h"

struct dx_service_request {
    const char *command; /* "dexel reload" */
    const char *request; /* "{\"request\":\"reload\"}" */
    const char *help;
    int timeout_ms;   /* how long the answer may take */
    const char *late; /* told on standard error after five seconds without it; NULL: nothing */
    /* To standard output. -errno with a text: it cannot be shown. */
    int (*show)(const json_t *reply, struct dx_err *err);
};

/* The exit status; 1 too when the answer tells of "trouble". */
int dx_service_request_run(const struct dx_service_request *r, int argc, char **argv);

#define DX_SERVICE_REQUEST_HELP                                                                    \
    "  --socket PATH  control socket, or a mesh socket with one beside it (PATH.control);\n"       \
    "                 default $DEXELD_CONTROL, else /run/dexeld/control.sock\n"                    \
    "  --json         the service's own line\n"

#endif
