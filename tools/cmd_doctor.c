/* dexel doctor: what is wrong with this installation, and the commands that mend it. */
#include "tools/args.h"
#include "tools/cmd.h"
#include "tools/doctor.h"
#include "tools/stats_json.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char help[] =
    "usage: dexel doctor [OPTIONS]\n"
    "Looks for what keeps dexeld from working well on this machine, and tells the command that\n"
    "mends it. Changes nothing. Exit status 1 when there is a problem; warnings are none.\n\n"
    "  --config FILE   the service's configuration (/etc/dexeld/dexeld.yaml)\n"
    "  --socket PATH   its mesh socket, where that is not the configured one\n"
    "  --control PATH  its control socket; default PATH.control with --socket, else\n"
    "                  $DEXELD_CONTROL, else the configured one\n"
    "  --quiet         warnings and problems alone\n"
    "  --json          one JSON object on standard output\n";

enum { OPT_CONFIG = 256, OPT_SOCKET, OPT_CONTROL, OPT_QUIET, OPT_JSON, OPT_HELP };

static const struct option options[] = {
    {"config", required_argument, NULL, OPT_CONFIG},
    {"socket", required_argument, NULL, OPT_SOCKET},
    {"control", required_argument, NULL, OPT_CONTROL},
    {"quiet", no_argument, NULL, OPT_QUIET},
    {"json", no_argument, NULL, OPT_JSON},
    {"help", no_argument, NULL, OPT_HELP},
    {0},
};

struct args {
    const char *config, *socket, *control;
    char beside[128]; /* PATH.control */
    bool is_control_of_env;
    bool quiet, json;
};

static int set_option(struct args *a, int opt, const char *text)
{
    switch (opt) {
    case OPT_CONFIG:
        a->config = text;
        return 0;
    case OPT_SOCKET:
        a->socket = text;
        return 0;
    case OPT_CONTROL:
        a->control = text;
        return 0;
    case OPT_QUIET:
        a->quiet = true;
        return 0;
    case OPT_JSON:
        a->json = true;
        return 0;
    default:
        return -EINVAL; /* getopt has said what it did not know */
    }
}

/* The one beside the mesh socket that was named, or that of the environment. */
static void find_control(struct args *a)
{
    const char *env = getenv("DEXELD_CONTROL");

    if (a->control)
        return;
    if (a->socket) {
        snprintf(a->beside, sizeof(a->beside), "%s.control", a->socket);
        a->control = a->beside;
    } else if (env && *env) {
        a->control = env;
        a->is_control_of_env = true;
    }
}

static int parse(struct args *a, int argc, char **argv)
{
    int opt;

    while ((opt = getopt_long(argc, argv, "", options, NULL)) != -1) {
        if (opt == OPT_HELP)
            return dx_arg_help(help);
        if (set_option(a, opt, optarg) < 0)
            return -EINVAL;
    }
    if (optind < argc) {
        fprintf(stderr, "dexel doctor: found '%s', expected options only\n", argv[optind]);
        return -EINVAL;
    }
    find_control(a);
    return 0;
}

static void print_text(const struct dx_doctor *d, bool quiet)
{
    const unsigned n_problems = d->n_of[DX_DOCTOR_PROBLEM], n_warnings = d->n_of[DX_DOCTOR_WARNING];

    for (size_t k = 0; k < json_array_size(d->findings); k++) {
        const json_t *f = json_array_get(d->findings, k);
        const char *level = json_string_value(json_object_get(f, "level"));
        const char *mend = json_string_value(json_object_get(f, "mend"));

        if (quiet && !strcmp(level, "ok"))
            continue;
        printf("%-8s %-8s %s\n", level, json_string_value(json_object_get(f, "topic")),
               json_string_value(json_object_get(f, "text")));
        if (mend)
            printf("%17s $ %s\n", "", mend);
    }
    printf("%u problem%s, %u warning%s\n", n_problems, n_problems == 1 ? "" : "s", n_warnings,
           n_warnings == 1 ? "" : "s");
}

static int print_json(const struct dx_doctor *d)
{
    return dx_json_print(json_pack("{s:i, s:i, s:O}", "problems", (int)d->n_of[DX_DOCTOR_PROBLEM],
                                   "warnings", (int)d->n_of[DX_DOCTOR_WARNING], "findings",
                                   d->findings),
                         "dexel doctor");
}

int cmd_doctor(int argc, char **argv)
{
    struct args a = {0};
    const char *root = getenv("DEXEL_DOCTOR_ROOT"); /* of tests: a machine made of files */
    struct dx_doctor d = {.root = root ? root : "", .findings = json_array()};
    int r = parse(&a, argc, argv);

    if (r == 0) {
        d.config_path = a.config;
        d.socket = a.socket;
        d.control = a.control;
        d.is_control_of_env = a.is_control_of_env;
        dx_doctor_run(&d);
        if (!a.json)
            print_text(&d, a.quiet);
        else if (print_json(&d) < 0)
            d.n_of[DX_DOCTOR_PROBLEM]++;
    }
    dx_config_fini(&d.config);
    json_decref(d.findings);
    if (r != 0)
        return r == DX_ARG_E_HELP ? 0 : 2;
    return d.n_of[DX_DOCTOR_PROBLEM] ? 1 : 0;
}
