/* dexel log-level: how much a running dexeld logs. */
#include "tools/cmd.h"
#include "tools/stream_request.h"

#include <stdio.h>

static const char command[] = "dexel log-level";

static const char help[] =
    "usage: dexel log-level [error|warning|notice|info|debug] [--socket PATH] [--json]\n"
    "Tells the least important messages that a running dexeld logs, or changes that until it "
    "ends;\n"
    "the configuration stays as it is.\n\n" DX_SERVICE_REQUEST_HELP;

static int take(json_t *request, int n, char **words)
{
    if (n > 1)
        return dx_stream_request_bad(command, words[1], "one level");
    if (n == 1) /* which there are the service knows */
        json_object_set_new(request, "level", json_string(words[0]));
    return 0;
}

static void show(const json_t *reply)
{
    const char *level = json_string_value(json_object_get(reply, "level"));

    puts(level ? level : "-");
}

int cmd_log_level(int argc, char **argv)
{
    static const struct dx_stream_request r = {.command = command,
                                               .request = "log-level",
                                               .help = help,
                                               .take = take,
                                               .show = show,
                                               .of_service = true};

    return dx_stream_request_run(&r, argc, argv);
}
