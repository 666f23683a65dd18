/* The table of requests, and those of them that need no file of their own. Loop thread. */
#include "daemon/control_requests.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "daemon/control_clients.h"
#include "daemon/control_config.h"
#include "daemon/control_devices.h"
#include "daemon/control_metrics.h"
#include "daemon/control_service.h"
#include "daemon/control_stream.h"
#include "daemon/log.h"
#include "daemon/server_priv.h"
#include "daemon/status.h"

static json_t *answer_status(struct dx_server *server, const json_t *request)
{
    (void)request;
    return dx_status(server, false);
}

static const struct request {
    const char *name;
    json_t *(*answer)(struct dx_server *server, const json_t *request);
    const char *changes; /* one that has this member changes something; NULL: none does */
    /* Begins what takes longer, and returns its number; 0: it cannot, and `answer` says why. NULL:
     * the answer is there at once. */
    uint64_t (*begin)(struct dx_server *server);
    enum dx_control_topic topic;
} requests[] = {
    {"status", answer_status, NULL, NULL, 0},
    {"metrics", dx_control_metrics, NULL, NULL, 0},
    {"devices", dx_control_no_devices, NULL, dx_control_begin_devices, DX_TOPIC_DEVICES},
    {"clients", dx_control_clients, "do", NULL, 0},
    {"record", dx_control_record, "do", NULL, 0},
    {"replay", dx_control_replay, "do", NULL, 0},
    {"log-level", dx_control_log_level, "level", NULL, 0},
    {"config", dx_control_config, NULL, NULL, 0},
    {"reload", dx_control_no_reload, "request", dx_control_begin_reload, DX_TOPIC_RELOAD},
    {"quit", dx_control_quit, "request", NULL, 0},
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

static bool has_changed(const struct request *r, const json_t *request, const json_t *reply)
{
    const char *verb = json_string_value(json_object_get(request, "do"));

    return r->changes && json_object_get(request, r->changes) && !json_object_get(reply, "error") &&
           (!verb || strcmp(verb, "status") != 0);
}

static void log_change(const json_t *request, const struct ucred *who)
{
    char *text = json_dumps(request, JSON_COMPACT);

    dx_log_notice("control", "pid %d uid %u asked for %s", (int)who->pid, (unsigned)who->uid,
                  text ? text : "a change");
    free(text);
}

static json_t *obey(const struct request *r, struct dx_server *server, const json_t *request,
                    const struct ucred *who, struct dx_control_wait *wait)
{
    const uint64_t number = r->begin ? r->begin(server) : 0;
    json_t *reply = number ? NULL : r->answer(server, request);

    if (number)
        *wait = (struct dx_control_wait){r->topic, number};
    if (has_changed(r, request, reply))
        log_change(request, who);
    return reply;
}

json_t *dx_control_answer(struct dx_server *server, const json_t *request, const struct ucred *who,
                          struct dx_control_wait *wait)
{
    const char *what = json_string_value(json_object_get(request, "request"));

    *wait = (struct dx_control_wait){0};
    if (!what)
        return json_pack("{s:s}", "error", "expected an object with a string \"request\"");
    for (size_t k = 0; k < N_REQUESTS; k++)
        if (!strcmp(what, requests[k].name))
            return obey(&requests[k], server, request, who, wait);
    return unknown(what);
}
