/* The configuration in force, and what a reload has done, as answers of the control socket. Loop
 * thread. */
#include "daemon/control_config.h"

#include "daemon/control.h"
#include "daemon/reload_report.h"
#include "daemon/server_priv.h"

#include <stdlib.h>

/* Texts of the file are UTF-8; its name, and the words of a command line, may be any bytes. */
static json_t *text_of(char *yaml)
{
    json_t *text = json_string(yaml);

    for (char *p = yaml; !text && *p; p++)
        *p = *p & (char)0x80 ? '?' : *p;
    return text ? text : json_string(yaml);
}

json_t *dx_control_config(struct dx_server *server, const json_t *request)
{
    char *yaml = server->options.config ? server->options.config(server->options.ctx) : NULL;
    json_t *answer;

    (void)request;
    if (!yaml)
        return json_pack("{s:s}", "error", "the configuration cannot be told: no memory");
    answer = json_pack("{s:o}", "yaml", text_of(yaml));
    free(yaml);
    return answer;
}

static bool is_waiting(const struct dx_server *server, char stream[64])
{
    return server->options.reload_waits &&
           server->options.reload_waits(server->options.ctx, stream);
}

uint64_t dx_control_begin_reload(struct dx_server *server)
{
    char stream[64];

    return is_waiting(server, stream) ? 0 : dx_server_reload(server);
}

json_t *dx_control_no_reload(struct dx_server *server, const json_t *request)
{
    char stream[64];

    (void)request;
    if (!server->exit_due_ns && is_waiting(server, stream))
        return json_pack("{s:o}", "error",
                         json_sprintf("a reload is under way (stream %s)", stream));
    return json_pack("{s:s}", "error",
                     server->exit_due_ns ? "the service is stopping"
                                         : "there is no configuration file to read again");
}

static json_t *names(const struct dx_reload_report *report, enum dx_reload_did did)
{
    json_t *list = json_array();

    for (uint32_t k = 0; k < report->n_streams; k++)
        if (report->stream[k].did == did)
            json_array_append_new(list, json_string(report->stream[k].name));
    return list;
}

static json_t *fixed_keys(const struct dx_reload_report *report)
{
    json_t *list = json_array();

    for (unsigned k = 0; k < report->n_fixed; k++)
        json_array_append_new(list, json_string(report->fixed[k]));
    return list;
}

/* Texts that are not UTF-8, as the name of a file may be, stay out. */
static json_t *done(const struct dx_reload_report *report)
{
    static const char *const did[DX_RELOAD_N_DID] = {"added", "changed", "removed", "unchanged"};
    json_t *o = json_object();

    json_object_set_new(o, "file", json_string(report->file));
    for (int k = 0; k < DX_RELOAD_N_DID; k++)
        json_object_set_new(o, did[k], names(report, (enum dx_reload_did)k));
    json_object_set_new(o, "restart", fixed_keys(report));
    if (report->err.text[0])
        json_object_set_new(o, "trouble", json_string(report->err.text));
    return o;
}

static json_t *refused(const struct dx_reload_report *report)
{
    json_t *text = json_string(report->err.text);

    return json_pack("{s:o}", "error", text ? text : json_string("the configuration is not right"));
}

void dx_control_reloaded(struct dx_server *server, uint64_t number,
                         const struct dx_reload_report *report)
{
    json_t *reply = report->is_refused ? refused(report) : done(report);

    dx_control_tell(server->control, (struct dx_control_wait){DX_TOPIC_RELOAD, number}, reply);
    json_decref(reply);
}
