/* dexel devices: what is attached, which driver takes it, and the YAML to paste. */
#include "tools/args.h"
#include "tools/cmd.h"
#include "tools/control_client.h"
#include "tools/devices.h"
#include "tools/stdout.h"

#include <errno.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>

static const char help[] =
    "usage: dexel devices [--json] [--service] [--socket PATH]\n"
    "Lists the attached devices that dexeld has a driver for, as streams to paste into its\n"
    "configuration. One that this user may not open is shown with the udev rule that grants it.\n\n"
    "  --json         one JSON object on standard output\n"
    "  --service      ask a running dexeld: what it sees and may open, and which stream has what\n"
    "  --socket PATH  the same; control socket, or a mesh socket with one beside it\n"
    "                 (PATH.control); default $DEXELD_CONTROL, else /run/dexeld/control.sock\n";

struct args {
    const char *socket;
    bool json, service;
};

static int parse(struct args *a, int argc, char **argv)
{
    enum { OPT_JSON = 256, OPT_SERVICE, OPT_SOCKET, OPT_HELP };
    static const struct option options[] = {
        {"json", no_argument, NULL, OPT_JSON},
        {"service", no_argument, NULL, OPT_SERVICE},
        {"socket", required_argument, NULL, OPT_SOCKET},
        {"help", no_argument, NULL, OPT_HELP},
        {0},
    };
    int opt;

    while ((opt = getopt_long(argc, argv, "", options, NULL)) != -1) {
        if (opt == OPT_HELP)
            return dx_arg_help(help);
        if (opt == '?')
            return -EINVAL; /* getopt has said what it did not know */
        a->json |= opt == OPT_JSON;
        a->service |= opt != OPT_JSON;
        a->socket = opt == OPT_SOCKET ? optarg : a->socket;
    }
    if (optind == argc)
        return 0;
    fprintf(stderr, "dexel devices: found '%s', expected no argument\n", argv[optind]);
    return -EINVAL;
}

static int put_answer(const char *line, bool json, const char *path, struct dx_err *err)
{
    json_t *reply;
    int rc = dx_control_take(&reply, line, path, err);

    if (rc == 0 && json)
        dx_stdout_put_line(line);
    else if (rc == 0)
        rc = dx_devices_print_reply(stdout, reply);
    json_decref(reply);
    return rc;
}

static int ask_service(const struct args *a)
{
    struct dx_err err = {""};
    char path[108], *line = NULL;
    int rc = dx_control_path(path, a->socket, &err);

    if (rc == 0)
        rc = dx_control_ask(&line, path, "{\"request\":\"devices\"}", &err);
    if (rc == 0)
        rc = put_answer(line, a->json, path, &err);
    if (*err.text)
        fprintf(stderr, "dexel devices: %s\n", err.text);
    free(line);
    return rc;
}

int cmd_devices(int argc, char **argv)
{
    struct args a = {0};
    int rc = parse(&a, argc, argv);

    if (rc != 0)
        return rc == DX_ARG_E_HELP ? 0 : 2;
    rc = a.service ? ask_service(&a) : dx_devices_print(stdout, dx_drivers, a.json);
    return rc < 0 ? 1 : 0;
}
