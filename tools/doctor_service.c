/* What the service says of itself. */
#include "tools/doctor.h"

#include "tools/control_client.h"

#include <stdlib.h>
#include <string.h>

#define LOG "journalctl -u dexeld -n 50"

/* A scanner on the network, which no unit without a drop-in can reach. */
static bool is_out_of_reach(const struct dx_doctor *d, const char *name)
{
    const struct dx_stream_config *s = dx_doctor_stream(d, name);

    return s && !strcmp(s->driver, "hokuyo") && *s->source.hokuyo.tcp && dx_doctor_is_offline(d);
}

static void look_at_state(struct dx_doctor *d, const char *name, const char *state,
                          const char *reason)
{
    const bool is_bad = !strcmp(state, "faulted") || !strcmp(state, "gone");

    if (is_bad && is_out_of_reach(d, name))
        dx_doctor_tell(d, DX_DOCTOR_PROBLEM, dx_doctor_network_command(d),
                       "%s is %s: %s; the service's unit keeps it from the network", name, state,
                       reason ? reason : "");
    else if (is_bad)
        dx_doctor_tell(d, DX_DOCTOR_PROBLEM, !strcmp(state, "gone") ? "dexel devices" : LOG,
                       "%s is %s: %s", name, state, reason ? reason : "");
    else if (!strcmp(state, "stalled") || (reason && *reason))
        dx_doctor_tell(d, DX_DOCTOR_WARNING, LOG, "%s is %s: %s", name, state,
                       reason ? reason : "");
    else
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "%s is %s", name, state);
}

static void look_at_recording(struct dx_doctor *d, const char *name, const json_t *recording)
{
    const char *error = json_string_value(json_object_get(recording, "error_text"));
    const char *path = json_string_value(json_object_get(recording, "path"));

    if (error)
        dx_doctor_tell(
            d, DX_DOCTOR_PROBLEM, dx_doctor_ask_command(d, "dexel record status --stream @", name),
            "%s is not recorded%s%s: %s", name, path ? " in " : "", path ? path : "", error);
}

static void look_at_stream(struct dx_doctor *d, const json_t *stream)
{
    const char *name = json_string_value(json_object_get(stream, "name"));
    const char *state = json_string_value(json_object_get(stream, "state"));
    const json_t *device = json_object_get(stream, "device");
    const char *trouble = json_string_value(json_object_get(device, "trouble"));

    if (!name || !state)
        return;
    if (!strcmp(state, "live") || !dx_doctor_is_missing(d, name)) /* one fault is told once */
        look_at_state(d, name, state, json_string_value(json_object_get(stream, "reason")));
    if (trouble && *trouble)
        dx_doctor_tell(d, DX_DOCTOR_WARNING, LOG, "%s: %s", name, trouble);
    look_at_recording(d, name, json_object_get(stream, "recording"));
}

static void look_at_status(struct dx_doctor *d, const json_t *status)
{
    const char *version = json_string_value(json_object_get(status, "version"));
    const json_t *streams = json_object_get(status, "streams");

    if (!version || strcmp(version, DEXELD_VERSION))
        dx_doctor_tell(d, DX_DOCTOR_WARNING, "sudo systemctl restart dexeld",
                       "the service is of version %s, these tools are of " DEXELD_VERSION,
                       version ? version : "unknown");
    else
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "the service answers, version %s", version);
    for (size_t k = 0; k < json_array_size(streams); k++)
        look_at_stream(d, json_array_get(streams, k));
}

void dx_doctor_service(struct dx_doctor *d)
{
    const char *path = dx_doctor_control_path(d);
    char whole[PATH_MAX], *reply;
    struct dx_err err;
    json_t *status;

    if (!d->answers) /* told of the sockets */
        return;
    dx_doctor_path(d, whole, sizeof(whole), path);
    if (dx_control_ask(&reply, whole, "{\"request\":\"status\"}", &err) < 0) {
        dx_doctor_tell(d, DX_DOCTOR_PROBLEM, dx_doctor_restart_command(d, path), "%s", err.text);
        return;
    }
    if (dx_control_take(&status, reply, whole, &err) < 0)
        dx_doctor_tell(d, DX_DOCTOR_WARNING, NULL, "%s", err.text);
    else
        look_at_status(d, status);
    json_decref(status);
    free(reply);
}
