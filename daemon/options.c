/* The command line of dexeld. */
#include "daemon/options.h"

#include <errno.h>
#include <getopt.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

static const char help[] =
    "usage: dexeld -c FILE [--check]\n"
    "       dexeld --replay FILE [--rate real|max|N] [--loop] [--wait N] [--start S] [--end S]\n"
    "              [--stamps original|new] --socket PATH\n"
    "Reads range scanners, meshes what they see, and serves the mesh on a Unix socket.\n\n"
    "  -c, --config FILE   the configuration, dexeld.yaml(5)\n"
    "  --check             say whether it is right, and end\n"
    "  --replay FILE       no configuration: serve a scan, a directory or a glob of them\n"
    "  --rate real|max|N   as fast as it was recorded (real), as fast as possible, N times\n"
    "  --loop              start again at the end\n"
    "  --start S, --end S  of a recording: only this stretch, seconds from its start\n"
    "  --stamps original|new\n"
    "                      of a recording: device stamps as recorded (original), or new\n"
    "  --wait N            start when N have subscribed (0; at rate max 1)\n"
    "  --socket PATH       where the mesh is served; PATH.control takes requests\n"
    "  --ready-fd N        write a line to this descriptor when the sockets listen\n"
    "  --help, --version\n";

enum {
    OPT_CHECK = 256,
    OPT_REPLAY,
    OPT_RATE,
    OPT_LOOP,
    OPT_WAIT,
    OPT_START,
    OPT_END,
    OPT_STAMPS,
    OPT_SOCKET,
    OPT_READY,
    OPT_HELP,
    OPT_VERSION
};

static const struct option options[] = {
    {"config", required_argument, NULL, 'c'},
    {"check", no_argument, NULL, OPT_CHECK},
    {"replay", required_argument, NULL, OPT_REPLAY},
    {"rate", required_argument, NULL, OPT_RATE},
    {"loop", no_argument, NULL, OPT_LOOP},
    {"wait", required_argument, NULL, OPT_WAIT},
    {"start", required_argument, NULL, OPT_START},
    {"end", required_argument, NULL, OPT_END},
    {"stamps", required_argument, NULL, OPT_STAMPS},
    {"socket", required_argument, NULL, OPT_SOCKET},
    {"ready-fd", required_argument, NULL, OPT_READY},
    {"help", no_argument, NULL, OPT_HELP},
    {"version", no_argument, NULL, OPT_VERSION},
    {0},
};

__attribute__((format(printf, 1, 2))) static int wrong(const char *format, ...)
{
    va_list args;

    fputs("dexeld: ", stderr);
    va_start(args, format);
    vfprintf(stderr, format, args);
    va_end(args);
    fputs("\n`dexeld --help` tells the options.\n", stderr);
    return 2;
}

static int set_ready_fd(struct dx_options *o, const char *text)
{
    char *end;
    long n = strtol(text, &end, 10);

    if (*text == '\0' || *end != '\0' || n < 0 || n > 1 << 20) {
        fprintf(stderr, "dexeld: --ready-fd: found '%s', expected a descriptor's number\n", text);
        return 2;
    }
    o->ready_fd = (int)n;
    return DX_OPTIONS_RUN;
}

static int set_option(struct dx_options *o, int opt, const char *text)
{
    switch (opt) {
    case 'c':
        o->config = text;
        return DX_OPTIONS_RUN;
    case OPT_CHECK:
        o->check = true;
        return DX_OPTIONS_RUN;
    case OPT_REPLAY:
        o->replay.path = text;
        return DX_OPTIONS_RUN;
    case OPT_RATE:
        o->replay.rate = text;
        return DX_OPTIONS_RUN;
    case OPT_LOOP:
        o->replay.loop = true;
        return DX_OPTIONS_RUN;
    case OPT_WAIT:
        o->replay.wait = text;
        return DX_OPTIONS_RUN;
    case OPT_START:
        o->replay.start = text;
        return DX_OPTIONS_RUN;
    case OPT_END:
        o->replay.end = text;
        return DX_OPTIONS_RUN;
    case OPT_STAMPS:
        o->replay.stamps = text;
        return DX_OPTIONS_RUN;
    case OPT_SOCKET:
        o->replay.socket = text;
        return DX_OPTIONS_RUN;
    case OPT_READY:
        return set_ready_fd(o, text);
    case OPT_HELP:
        fputs(help, stdout);
        return 0;
    case OPT_VERSION:
        puts("dexeld " DEXELD_VERSION);
        return 0;
    default:
        return 2; /* getopt has said why */
    }
}

/* Do the options go together? */
static int check(const struct dx_options *o, int argc, char **argv)
{
    const struct dx_config_replay *r = &o->replay;
    bool replay_words =
        r->rate || r->wait || r->loop || r->socket || r->start || r->end || r->stamps;

    if (optind < argc)
        return wrong("found '%s', expected options only", argv[optind]);
    if (!o->config == !o->replay.path)
        return wrong("found neither or both of -c and --replay, expected one");
    if (o->config && replay_words)
        return wrong(
            "--rate, --loop, --wait, --start, --end, --stamps and --socket go with --replay");
    if (o->replay.path && o->check)
        return wrong("--check goes with -c");
    if (o->replay.path && !o->replay.socket)
        return wrong("--replay needs --socket PATH");
    return DX_OPTIONS_RUN;
}

int dx_options_parse(struct dx_options *o, int argc, char **argv)
{
    int opt, status;

    *o = (struct dx_options){.ready_fd = -1};
    while ((opt = getopt_long(argc, argv, "c:", options, NULL)) != -1) {
        status = set_option(o, opt, optarg);
        if (status != DX_OPTIONS_RUN)
            return status;
    }
    return check(o, argc, argv);
}

int dx_options_config(struct dx_config *config, const struct dx_options *o, struct dx_err *err)
{
    if (o->config)
        return dx_config_load(config, o->config, err);
    return dx_config_for_replay(config, &o->replay, err);
}
