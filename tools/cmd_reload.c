/* dexel reload: has a running dexeld read its configuration again, and tells what became of it. */
#include "tools/cmd.h"
#include "tools/service_request.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>

static const char help[] =
    "usage: dexel reload [--socket PATH] [--json]\n"
    "Has a running dexeld read its configuration file again. Streams that are the same there go "
    "on\n"
    "undisturbed; a file that is not right changes nothing. Waits up to two minutes for sources "
    "to\n"
    "be opened; the service goes on by itself.\n\n" DX_SERVICE_REQUEST_HELP;

/* Names, or nothing at all. */
static bool has_names(const json_t *reply, const char *key)
{
    const json_t *list = json_object_get(reply, key);
    bool good = !list || json_is_array(list);

    for (size_t k = 0; k < json_array_size(list); k++)
        good = good && json_is_string(json_array_get(list, k));
    return good;
}

/* ": hall, box" */
static void put_names(const json_t *list)
{
    for (size_t k = 0; k < json_array_size(list); k++)
        printf("%s %s", k ? "," : ":", json_string_value(json_array_get(list, k)));
    putchar('\n');
}

static int show(const json_t *reply, struct dx_err *err)
{
    static const char *const did[] = {"added", "changed", "removed", "unchanged", "restart"};
    const json_t *restart = json_object_get(reply, "restart");

    for (size_t k = 0; k < sizeof(did) / sizeof(did[0]); k++)
        if (!has_names(reply, did[k]))
            return dx_err_set(err, -EBADMSG,
                              "the service: found something else in '%s', expected names", did[k]);
    for (size_t k = 0; k + 1 < sizeof(did) / sizeof(did[0]); k++) {
        const json_t *list = json_object_get(reply, did[k]);

        printf("%zu %s", json_array_size(list), did[k]);
        put_names(list);
    }
    if (json_array_size(restart)) {
        printf("from the next start on");
        put_names(restart);
    }
    return 0;
}

int cmd_reload(int argc, char **argv)
{
    static const struct dx_service_request r = {
        .command = "dexel reload",
        .request = "{\"request\":\"reload\"}",
        .help = help,
        .timeout_ms = 120000, /* sources are opened, threads waited for */
        .late = "dexel reload: the service is still opening sources, and goes on by itself",
        .show = show,
    };

    return dx_service_request_run(&r, argc, argv);
}
