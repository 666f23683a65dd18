/* dexel clients: who is connected to a running dexeld, and ending one of them. */
#include "tools/cmd.h"
#include "tools/stream_request.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>

static const char command[] = "dexel clients";

static const char help[] =
    "usage: dexel clients [--disconnect N] [--socket PATH] [--json]\n"
    "Lists the subscribers of a running dexeld, or ends the connection of one: it is told so.\n\n"
    "  --disconnect N  the one of this number, as the list has it\n" DX_SERVICE_REQUEST_HELP;

static int take(json_t *request, int n, char **words)
{
    (void)request;
    return n == 0 ? 0 : dx_stream_request_bad(command, words[0], "options only");
}

static int take_disconnect(json_t *request, const char *value)
{
    char *end;
    long long number;

    errno = 0;
    number = strtoll(value, &end, 10);
    if (errno || end == value || *end || number < 1)
        return dx_stream_request_bad("dexel clients: --disconnect", value, "a client's number");
    json_object_set_new(request, "do", json_string("disconnect"));
    return json_object_set_new(request, "number", json_integer(number));
}

static const char *text(const json_t *o, const char *key)
{
    const char *s = json_string_value(json_object_get(o, key));

    return s ? s : "-";
}

static double number(const json_t *o, const char *key)
{
    return json_number_value(json_object_get(o, key));
}

static void show(const json_t *reply)
{
    const json_t *clients = json_object_get(reply, "clients");
    const json_t *n = json_object_get(reply, "disconnected");
    const json_t *c;
    size_t k;

    if (n) {
        printf("%lld disconnected\n", (long long)json_integer_value(n));
        return;
    }
    printf("%8s %8s %6s %-16s %-8s %-8s %8s %12s\n", "NUMBER", "PID", "UID", "STREAM", "ENCODING",
           "MODE", "EPOCHS", "BYTES");
    json_array_foreach(clients, k, c)
        printf("%8.0f %8.0f %6.0f %-16s %-8s %-8s %8.0f %12.0f\n", number(c, "number"),
               number(c, "pid"), number(c, "uid"), text(c, "stream"), text(c, "encoding"),
               text(c, "mode"), number(c, "epochs"), number(c, "bytes"));
}

int cmd_clients(int argc, char **argv)
{
    static const struct dx_stream_request r = {.command = command,
                                               .request = "clients",
                                               .help = help,
                                               .take = take,
                                               .show = show,
                                               .of_service = true,
                                               .option = "disconnect",
                                               .take_option = take_disconnect};

    return dx_stream_request_run(&r, argc, argv);
}
