/* dexel config: the configuration that a running dexeld has in force, and where each value is from.
 */
#include "tools/cmd.h"
#include "tools/service_request.h"
#include "tools/stdout.h"

#include <errno.h>
#include <stdio.h>

static const char help[] = "usage: dexel config [--socket PATH] [--json]\n"
                           "Prints the configuration that a running dexeld has in force: every key "
                           "with its value, and where\n"
                           "that is from, as YAML that dexeld reads.\n\n" DX_SERVICE_REQUEST_HELP;

static int show(const json_t *reply, struct dx_err *err)
{
    const char *yaml = json_string_value(json_object_get(reply, "yaml"));

    if (!yaml)
        return dx_err_set(err, -EBADMSG, "the service: found no \"yaml\" in its answer");
    dx_stdout_put(yaml);
    return 0;
}

int cmd_config(int argc, char **argv)
{
    static const struct dx_service_request r = {
        .command = "dexel config",
        .request = "{\"request\":\"config\"}",
        .help = help,
        .timeout_ms = 5000,
        .show = show,
    };

    return dx_service_request_run(&r, argc, argv);
}
