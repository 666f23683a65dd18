/* dexel quit: ends a running dexeld. */
#include "tools/cmd.h"
#include "tools/stream_request.h"

static const char command[] = "dexel quit";

static const char help[] = "usage: dexel quit [--socket PATH] [--json]\n"
                           "Ends a running dexeld, as SIGTERM does. Under a service manager "
                           "systemctl is the way: it knows\n"
                           "then that the service was meant to end.\n\n" DX_SERVICE_REQUEST_HELP;

static int take(json_t *request, int n, char **words)
{
    (void)request;
    return n == 0 ? 0 : dx_stream_request_bad(command, words[0], "options only");
}

static void show(const json_t *reply)
{
    (void)reply;
}

int cmd_quit(int argc, char **argv)
{
    static const struct dx_stream_request r = {.command = command,
                                               .request = "quit",
                                               .help = help,
                                               .take = take,
                                               .show = show,
                                               .of_service = true};

    return dx_stream_request_run(&r, argc, argv);
}
