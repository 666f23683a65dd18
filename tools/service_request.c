/* Options, asking, and what the service refuses. */
#include "tools/service_request.h"

#include "tools/args.h"
#include "tools/control_client.h"
#include "tools/stdout.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

struct args {
    const char *socket;
    bool json;
};

static int parse(struct args *a, const struct dx_service_request *r, int argc, char **argv)
{
    enum { OPT_SOCKET = 256, OPT_JSON, OPT_HELP };
    static const struct option options[] = {
        {"socket", required_argument, NULL, OPT_SOCKET},
        {"json", no_argument, NULL, OPT_JSON},
        {"help", no_argument, NULL, OPT_HELP},
        {0},
    };
    int opt;

    while ((opt = getopt_long(argc, argv, "", options, NULL)) != -1) {
        if (opt == OPT_HELP)
            return dx_arg_help(r->help);
        if (opt != OPT_SOCKET && opt != OPT_JSON)
            return -EINVAL;
        a->socket = opt == OPT_SOCKET ? optarg : a->socket;
        a->json |= opt == OPT_JSON;
    }
    if (optind < argc) {
        fprintf(stderr, "%s: found '%s', expected options only\n", r->command, argv[optind]);
        return -EINVAL;
    }
    return 0;
}

static int show(const struct dx_service_request *r, const char *line, const char *path, bool json,
                struct dx_err *err)
{
    json_t *reply;
    int rc = dx_control_take(&reply, line, path, err);
    const char *trouble = json_string_value(json_object_get(reply, "trouble"));

    if (json)
        dx_stdout_put_line(line);
    else if (rc == 0)
        rc = r->show(reply, err);
    if (rc == 0 && trouble)
        rc = dx_err_set(err, -EBADMSG, "%s: the service: %s", path, trouble);
    json_decref(reply);
    return rc;
}

int dx_service_request_run(const struct dx_service_request *r, int argc, char **argv)
{
    struct args a = {0};
    struct dx_err err;
    char path[108], *line = NULL;
    int rc = parse(&a, r, argc, argv);

    if (rc != 0)
        return rc == DX_ARG_E_HELP ? 0 : 2;
    rc = dx_control_path(path, a.socket, &err);
    if (rc == 0)
        rc = dx_control_ask_within(&line, path, r->request, r->timeout_ms, r->late, &err);
    if (rc == 0)
        rc = show(r, line, path, a.json, &err);
    free(line);
    if (rc < 0)
        fprintf(stderr, "%s: %s\n", r->command, err.text);
    return rc < 0 ? 1 : 0;
}
