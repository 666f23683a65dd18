/* The table of requests, and those of them that need no file of their own. Loop thread. */
#include "daemon/control_requests.h"

#include <stdio.h>
#include <string.h>

#include "daemon/control_reload.h"
#include "daemon/control_stream.h"
#include "daemon/log.h"
#include "daemon/server_priv.h"
#include "daemon/status.h"

static json_t *answer_status(struct dx_server *server, const json_t *request)
{
    (void)request;
    return dx_status(server);
}

static json_t *answer_quit(struct dx_server *server, const json_t *request)
{
    (void)request;
    dx_log_info("control", "stopping: asked to quit");
    dx_server_stop(server);
    return json_object();
}

static const struct request {
    const char *name;
    json_t *(*answer)(struct dx_server *server, const json_t *request);
    /* Begins what takes longer, and returns its number; 0: it cannot, and `answer` says why. NULL:
     * the answer is there at once. */
    uint64_t (*begin)(struct dx_server *server);
} requests[] = {
    {"status", answer_status, NULL},     {"record", dx_control_record, NULL},
    {"replay", dx_control_replay, NULL}, {"reload", dx_control_no_reload, dx_server_reload},
    {"quit", answer_quit, NULL},
};

#define N_REQUESTS (sizeof(requests) / sizeof(*requests))

static json_t *unknown(const char *what)
{
    char names[512];
    size_t len = 0;

    for (size_t k = 0; k < N_REQUESTS && len < sizeof(names); k++) {
        const char *between = k == 0 ? "" : k + 1 < N_REQUESTS ? ", " : " or ";

        len +=
            (size_t)snprintf(names + len, sizeof(names) - len, "%s%s", between, requests[k].name);
    }
    return json_pack("{s:o}", "error",
                     json_sprintf("unknown request '%s', expected %s", what, names));
}

static json_t *obey(const struct request *r, struct dx_server *server, const json_t *request,
                    uint64_t *later)
{
    *later = r->begin ? r->begin(server) : 0;
    return *later ? NULL : r->answer(server, request);
}

json_t *dx_control_answer(struct dx_server *server, const json_t *request, uint64_t *later)
{
    const char *what = json_string_value(json_object_get(request, "request"));

    *later = 0;
    if (!what)
        return json_pack("{s:s}", "error", "expected an object with a string \"request\"");
    for (size_t k = 0; k < N_REQUESTS; k++)
        if (!strcmp(what, requests[k].name))
            return obey(&requests[k], server, request, later);
    return unknown(what);
}
