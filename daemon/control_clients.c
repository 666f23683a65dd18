/* clients, of the control socket. */
#include "daemon/control_clients.h"

#include "daemon/server_priv.h"
#include "daemon/status.h"

#include <string.h>

static json_t *wrong(json_t *text)
{
    return json_pack("{s:o}", "error", text);
}

static bool is_there(const struct dx_subscriber *s)
{
    return s->phase < DX_SUBSCRIBER_CLOSING;
}

static json_t *list(const struct dx_server *server)
{
    json_t *clients = json_array();

    for (const struct dx_subscriber *s = server->subscribers; s; s = s->next)
        if (is_there(s))
            json_array_append_new(clients, dx_status_client(s));
    return json_pack("{s:o}", "clients", clients);
}

/* A message that is half written is finished, so that the client can read why. */
static unsigned disconnect(struct dx_server *server, const char *key, json_int_t wanted)
{
    bool by_number = !strcmp(key, "number");
    unsigned n = 0;

    for (struct dx_subscriber *s = server->subscribers; s; s = s->next) {
        if (!is_there(s) || (by_number ? (json_int_t)s->number : (json_int_t)s->cred.pid) != wanted)
            continue;
        dx_subscriber_shut(s, DX_WIRE_E_DISMISSED, "disconnected by an operator", true);
        n++;
    }
    return n;
}

json_t *dx_control_clients(struct dx_server *server, const json_t *request)
{
    const json_t *verb = json_object_get(request, "do");
    const char *key = json_object_get(request, "number") ? "number" : "pid";
    const json_t *wanted = json_object_get(request, key);
    unsigned n;

    if (!verb)
        return list(server);
    if (!json_is_string(verb) || strcmp(json_string_value(verb), "disconnect") != 0)
        return wrong(json_string("\"do\": expected disconnect, or none for the list"));
    if (!json_is_integer(wanted))
        return wrong(json_string("expected a whole number as \"number\" or \"pid\""));
    n = disconnect(server, key, json_integer_value(wanted));
    if (n == 0)
        return wrong(
            json_sprintf("no client of %s %lld", key, (long long)json_integer_value(wanted)));
    return json_pack("{s:i}", "disconnected", (int)n);
}
