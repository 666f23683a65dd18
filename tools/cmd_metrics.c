/* dexel metrics: what a running dexeld counts, as the text that Prometheus reads. */
#include "tools/args.h"
#include "tools/cmd.h"
#include "tools/control_client.h"
#include "tools/stdout.h"

#include <errno.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char help[] =
    "usage: dexel metrics [--socket PATH] [--format openmetrics|prometheus]\n"
    "Prints what a running dexeld counts, as OpenMetrics text.\n\n"
    "  --socket PATH  control socket, or a mesh socket with one beside it (PATH.control);\n"
    "                 default $DEXELD_CONTROL, else /run/dexeld/control.sock\n"
    "  --format openmetrics|prometheus\n"
    "                 openmetrics (1.0), or prometheus: the text format 0.0.4 before it, which\n"
    "                 the textfile collector of node_exporter reads\n";

struct args {
    const char *socket, *format;
};

static int parse(struct args *a, int argc, char **argv)
{
    enum { OPT_SOCKET = 256, OPT_FORMAT, OPT_HELP };
    static const struct option options[] = {
        {"socket", required_argument, NULL, OPT_SOCKET},
        {"format", required_argument, NULL, OPT_FORMAT},
        {"help", no_argument, NULL, OPT_HELP},
        {0},
    };
    int opt;

    a->format = "openmetrics";
    while ((opt = getopt_long(argc, argv, "", options, NULL)) != -1) {
        if (opt == OPT_HELP)
            return dx_arg_help(help);
        if (opt != OPT_SOCKET && opt != OPT_FORMAT)
            return -EINVAL;
        *(opt == OPT_SOCKET ? &a->socket : &a->format) = optarg;
    }
    if (optind < argc) {
        fprintf(stderr, "dexel metrics: found '%s', expected options only\n", argv[optind]);
        return -EINVAL;
    }
    if (strcmp(a->format, "openmetrics") && strcmp(a->format, "prometheus")) {
        fprintf(stderr, "dexel metrics: --format: found '%s', expected openmetrics or prometheus\n",
                a->format);
        return -EINVAL;
    }
    return 0;
}

static int print(const char *line, const char *path, struct dx_err *err)
{
    json_t *reply;
    int rc = dx_control_take(&reply, line, path, err);
    const char *text = json_string_value(json_object_get(reply, "text"));

    if (rc == 0 && !text)
        rc = dx_err_set(err, -EBADMSG, "%s: found '%.40s', expected an object with \"text\"", path,
                        line);
    else if (rc == 0)
        dx_stdout_put(text);
    json_decref(reply);
    return rc;
}

int cmd_metrics(int argc, char **argv)
{
    struct args a = {0};
    char path[108], request[80], *line;
    struct dx_err err;
    int rc = parse(&a, argc, argv);

    if (rc != 0)
        return rc == DX_ARG_E_HELP ? 0 : 2;
    snprintf(request, sizeof(request), "{\"request\":\"metrics\",\"format\":\"%s\"}", a.format);
    rc = dx_control_path(path, a.socket, &err);
    if (rc == 0)
        rc = dx_control_ask(&line, path, request, &err);
    if (rc == 0) {
        rc = print(line, path, &err);
        free(line);
    }
    if (rc < 0)
        fprintf(stderr, "dexel metrics: %s\n", err.text);
    return rc < 0 ? 1 : 0;
}
