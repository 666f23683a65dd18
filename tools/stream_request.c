/* Options, asking, and what the service refuses. */
#include "tools/stream_request.h"

#include "tools/args.h"
#include "tools/control_client.h"
#include "tools/stdout.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

struct args {
    const char *socket, *stream, *option;
    bool json;
};

int dx_stream_request_bad(const char *command, const char *word, const char *expected)
{
    if (word)
        fprintf(stderr, "%s: found '%s', expected %s\n", command, word, expected);
    else
        fprintf(stderr, "%s: found nothing, expected %s\n", command, expected);
    return -EINVAL;
}

static int parse(struct args *a, const struct dx_stream_request *r, int argc, char **argv)
{
    enum { OPT_SOCKET = 256, OPT_STREAM, OPT_JSON, OPT_HELP, OPT_MORE, N_OPTIONS = 7 };
    struct option options[N_OPTIONS] = {
        {"socket", required_argument, NULL, OPT_SOCKET},
        {"json", no_argument, NULL, OPT_JSON},
        {"help", no_argument, NULL, OPT_HELP},
    };
    int opt, n = 3;

    if (!r->of_service)
        options[n++] = (struct option){"stream", required_argument, NULL, OPT_STREAM};
    if (r->option)
        options[n++] = (struct option){r->option, required_argument, NULL, OPT_MORE};

    while ((opt = getopt_long(argc, argv, "", options, NULL)) != -1) {
        if (opt == OPT_HELP)
            return dx_arg_help(r->help);
        if (opt == '?')
            return -EINVAL;
        a->option = opt == OPT_MORE ? optarg : a->option;
        a->socket = opt == OPT_SOCKET ? optarg : a->socket;
        a->stream = opt == OPT_STREAM ? optarg : a->stream;
        a->json |= opt == OPT_JSON;
    }
    return 0;
}

static int show(const struct dx_stream_request *r, const struct args *a, const char *path,
                const char *line, struct dx_err *err)
{
    json_t *reply;
    int rc = dx_control_take(&reply, line, path, err);

    if (rc == 0 && a->json)
        dx_stdout_put_line(line);
    else if (rc == 0)
        r->show(reply);
    json_decref(reply);
    return rc;
}

static int ask(const struct dx_stream_request *r, const struct args *a, const json_t *request,
               struct dx_err *err)
{
    char path[108], *line = NULL, *text = json_dumps(request, JSON_COMPACT);
    int rc = text ? dx_control_path(path, a->socket, err) : dx_err_set(err, -ENOMEM, "no memory");

    if (rc == 0)
        rc = dx_control_ask(&line, path, text, err);
    if (rc == 0)
        rc = show(r, a, path, line, err);
    free(line);
    free(text);
    return rc;
}

int dx_stream_request_run(const struct dx_stream_request *r, int argc, char **argv)
{
    struct args a = {0};
    struct dx_err err;
    json_t *request;
    int rc = parse(&a, r, argc, argv);

    if (rc != 0)
        return rc == DX_ARG_E_HELP ? 0 : 2;
    request = json_pack("{s:s}", "request", r->request);
    if (a.stream)
        json_object_set_new(request, "stream", json_string(a.stream));
    rc = r->take(request, argc - optind, argv + optind);
    if (rc == 0 && a.option)
        rc = r->take_option(request, a.option);
    if (rc == 0) {
        rc = ask(r, &a, request, &err);
        if (rc < 0)
            fprintf(stderr, "%s: %s\n", r->command, err.text);
        rc = rc < 0 ? 1 : 0;
    } else {
        rc = 2;
    }
    json_decref(request);
    return rc;
}
