/*
 * dexel bench live: a running service at its subscribers: latencies from a frame to its COMMIT, how
 * many can be served without a missed epoch, and what each stage adds, which the service tells.
 */
#include "tools/args.h"
#include "tools/bench.h"
#include "tools/bench_report.h"
#include "tools/bench_swarm.h"
#include "tools/control_client.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_STEPS 16
#define SETTLE_S  0.3 /* after the snapshots */

static const char help[] =
    "usage: dexel bench live --socket PATH [OPTIONS]\n"
    "Subscribes many times to a running service and measures what comes: latency from a\n"
    "frame's stamp to its COMMIT here, epochs missed, bytes.\n\n"
    "  --socket PATH          mesh socket of the service\n"
    "  --control PATH         its control socket: what each stage adds, since it was started\n"
    "  --stream NAME          which stream, where it has several\n"
    "  --encoding ENCODING    f32|q16|delta (delta)\n"
    "  --subscribers N[,..]   how many at once; up to 16 counts, one after the other (1)\n"
    "  --seconds S            measured, of each count (3)\n"
    "  --decode               decode tiles as well\n"
    "  --json                 one JSON object on standard output\n"
    "  --markdown             the tables as Markdown\n";

enum {
    OPT_SOCKET = 256,
    OPT_CONTROL,
    OPT_STREAM,
    OPT_ENCODING,
    OPT_SUBSCRIBERS,
    OPT_SECONDS,
    OPT_DECODE,
    OPT_JSON,
    OPT_MARKDOWN,
    OPT_HELP
};

static const struct option options[] = {
    {"socket", required_argument, NULL, OPT_SOCKET},
    {"control", required_argument, NULL, OPT_CONTROL},
    {"stream", required_argument, NULL, OPT_STREAM},
    {"encoding", required_argument, NULL, OPT_ENCODING},
    {"subscribers", required_argument, NULL, OPT_SUBSCRIBERS},
    {"seconds", required_argument, NULL, OPT_SECONDS},
    {"decode", no_argument, NULL, OPT_DECODE},
    {"json", no_argument, NULL, OPT_JSON},
    {"markdown", no_argument, NULL, OPT_MARKDOWN},
    {"help", no_argument, NULL, OPT_HELP},
    {0},
};

static const char *const encoding_names[] = {"f32", "q16", "delta", NULL};

struct args {
    struct dx_swarm_options swarm;
    uint32_t step[MAX_STEPS];
    uint32_t n_steps;
    const char *control;
    double seconds;
    enum dx_report_format format;
};

/* ---- telling ----------------------------------------------------------------------------------
 */

static const struct dx_report_column live_columns[] = {
    {"subscribers", "subscribers", 0}, {"encoding", "encoding", 0},
    {"epochs/s", "epochs_per_s", 2},   {"tiles changed, %", "tiles_percent", 2},
    {"MB/s", "mb_per_s", 1},           {"p50, ms", "p50_ms", 2},
    {"p99, ms", "p99_ms", 2},          {"max, ms", "max_ms", 2},
    {"missed", "missed", 0},           {"skipped", "skipped", 0},
    {"resets", "resets", 0},           {NULL, NULL, 0},
};

static const struct dx_report_column stage_columns[] = {
    {"subscribers", "subscribers", 0}, {"stage", "stage", 0}, {"p50, ms", "p50_ms", 2},
    {"p99, ms", "p99_ms", 2},          {NULL, NULL, 0},
};

static void tell_live(struct dx_report_table *t, const struct args *a,
                      const struct dx_swarm_figures *f, uint32_t n)
{
    json_t *row = dx_report_row(t);
    double commits = (double)f->n_commits;

    json_object_set_new(row, "subscribers", json_integer(n));
    json_object_set_new(row, "encoding", json_string(encoding_names[a->swarm.subscribe.encoding]));
    json_object_set_new(row, "seconds", json_real(f->seconds));
    json_object_set_new(row, "epochs_per_s", json_real(commits / n / f->seconds));
    json_object_set_new(row, "tiles_percent",
                        json_real(100 * (double)f->n_tiles / commits / f->grid_tiles));
    json_object_set_new(row, "mb_per_s", json_real((double)f->n_bytes * 1e-6 / f->seconds));
    json_object_set_new(row, "p50_ms", json_real(f->p50_ms));
    json_object_set_new(row, "p99_ms", json_real(f->p99_ms));
    json_object_set_new(row, "max_ms", json_real(f->max_ms));
    json_object_set_new(row, "missed", json_integer((json_int_t)f->n_missed));
    json_object_set_new(row, "skipped", json_integer((json_int_t)f->n_dropped));
    json_object_set_new(row, "resets", json_integer((json_int_t)f->n_resets));
}

static void tell_stage(struct dx_report_table *t, uint32_t n, const char *name, double p50,
                       double p99)
{
    json_t *row = dx_report_row(t);

    json_object_set_new(row, "subscribers", json_integer(n));
    json_object_set_new(row, "stage", json_string(name));
    json_object_set_new(row, "p50_ms", json_real(p50));
    json_object_set_new(row, "p99_ms", json_real(p99));
}

static double number(const json_t *o, const char *key)
{
    return json_number_value(json_object_get(o, key));
}

/* The stream's own histograms: of the only stream, or the one of that name. */
static const json_t *find_latency(const json_t *status, const char *stream)
{
    const json_t *s, *streams = json_object_get(status, "streams");
    size_t k;

    json_array_foreach(streams, k, s)
    {
        const char *name = json_string_value(json_object_get(s, "name"));

        if (!stream || (name && strcmp(name, stream) == 0))
            return json_object_get(s, "latency_ms");
    }
    return NULL;
}

static int tell_stages(struct dx_report_table *t, const struct args *a,
                       const struct dx_swarm_figures *f, uint32_t n, struct dx_err *err)
{
    static const char *const names[] = {"decode", "wait", "mesh", "encode", "send"};
    const json_t *latency, *stages;
    json_t *status;
    char *line;
    int rc = dx_control_ask(&line, a->control, "{\"request\":\"status\"}", err);

    if (rc < 0)
        return rc;
    status = json_loads(line, 0, NULL);
    free(line);
    latency = find_latency(status, a->swarm.subscribe.stream);
    stages = json_object_get(latency, "stages");
    for (size_t k = 0; stages && k < sizeof(names) / sizeof(names[0]); k++) {
        const json_t *stage = json_object_get(stages, names[k]);

        tell_stage(t, n, names[k], number(stage, "p50"), number(stage, "p99"));
    }
    if (stages) {
        tell_stage(t, n, "all, to the kernel", number(latency, "p50"), number(latency, "p99"));
        tell_stage(t, n, "all, at subscribers", f->p50_ms, f->p99_ms);
    } else {
        rc = dx_err_set(err, -EBADMSG, "%s: found no latencies in the status, expected them",
                        a->control);
    }
    json_decref(status);
    return rc;
}

/* ---- arguments --------------------------------------------------------------------------------
 */

static int set_subscribers(struct args *a, const char *text)
{
    struct dx_arg arg = {"dexel bench live", "--subscribers", text};
    char copy[256], *rest = copy, *one;

    a->n_steps = 0;
    if (strlen(text) >= sizeof(copy))
        return dx_arg_bad(&arg, "up to %u counts", MAX_STEPS);
    strcpy(copy, text);
    while ((one = strsep(&rest, ","))) {
        uint64_t n = 0;

        if (a->n_steps == MAX_STEPS)
            return dx_arg_bad(&arg, "up to %u counts", MAX_STEPS);
        if (dx_arg_u64(&n, &(struct dx_arg){arg.command, arg.option, one}, 1, DX_SWARM_MAX,
                       "subscribers") < 0)
            return -EINVAL;
        a->step[a->n_steps++] = (uint32_t)n;
    }
    return 0;
}

static int set_encoding(struct args *a, const char *text)
{
    int e = dx_arg_choice(&(struct dx_arg){"dexel bench live", "--encoding", text}, encoding_names);

    if (e >= 0)
        a->swarm.subscribe.encoding = (enum dexel_encoding)e;
    return e < 0 ? e : 0;
}

static int set_option(struct args *a, int opt, const char *text)
{
    switch (opt) {
    case OPT_SOCKET:
        a->swarm.subscribe.socket = text;
        return 0;
    case OPT_CONTROL:
        a->control = text;
        return 0;
    case OPT_STREAM:
        a->swarm.subscribe.stream = text;
        return 0;
    case OPT_ENCODING:
        return set_encoding(a, text);
    case OPT_SUBSCRIBERS:
        return set_subscribers(a, text);
    case OPT_SECONDS:
        return dx_arg_double(&a->seconds, &(struct dx_arg){"dexel bench live", "--seconds", text},
                             0.01, 3600, "seconds");
    case OPT_DECODE:
        a->swarm.decode = true;
        return 0;
    case OPT_JSON:
        a->format = DX_REPORT_JSON;
        return 0;
    case OPT_MARKDOWN:
        a->format = DX_REPORT_MARKDOWN;
        return 0;
    default:
        return -EINVAL; /* getopt has said why */
    }
}

static int parse(struct args *a, int argc, char **argv)
{
    int opt;

    *a = (struct args){.step = {1}, .n_steps = 1, .seconds = 3};
    a->swarm.subscribe.encoding = DEXEL_DELTA;
    while ((opt = getopt_long(argc, argv, "", options, NULL)) != -1) {
        if (opt == OPT_HELP)
            return dx_arg_help(help);
        if (set_option(a, opt, optarg) < 0)
            return -EINVAL;
    }
    if (optind == argc)
        return 0;
    fprintf(stderr, "dexel bench live: found '%s', expected options alone\n", argv[optind]);
    return -EINVAL;
}

static int run_step(const struct args *a, uint32_t n, struct dx_report_table *live,
                    struct dx_report_table *stages, struct dx_err *err)
{
    struct dx_swarm_options wanted = a->swarm;
    struct dx_swarm_figures f;
    struct dx_swarm *swarm = NULL;
    int rc;

    wanted.n_subscribers = n;
    rc = dx_swarm_open(&swarm, &wanted, err);
    if (rc == 0)
        rc = dx_swarm_run(swarm, SETTLE_S, &f, err);
    if (rc == 0)
        rc = dx_swarm_run(swarm, a->seconds, &f, err);
    if (rc == 0)
        tell_live(live, a, &f, n);
    if (rc == 0 && a->control)
        rc = tell_stages(stages, a, &f, n, err);
    dx_swarm_close(swarm);
    return rc;
}

int dx_bench_live(int argc, char **argv)
{
    struct dx_report_table live = {
        .name = "live",
        .title = "A running service at its subscribers",
        .text =
            "So many subscribers in one process that counts their tiles. Latency: from the "
            "stamp of a\nframe, taken when its bytes were there and before it is decoded, to "
            "its COMMIT at a subscriber,\nover all of them. *missed*: epochs that did not come, "
            "over all subscribers; *skipped*: frames that\nthe mesher skipped because newer ones "
            "were there; *resets*: subscribers who had to begin anew.",
        .columns = live_columns};
    struct dx_report_table stages = {
        .name = "latency",
        .title = "What each stage adds",
        .text =
            "*decode*: bytes to ranges (of a simulated scanner: the simulation); *wait*: for "
            "the mesher; *mesh*:\npublish and commit; *encode*; *send*: from there to the kernel, "
            "of each subscriber's COMMIT.\nBy the service's own histograms, which tell quantiles "
            "to an eighth.",
        .columns = stage_columns};
    struct dx_report report;
    struct dx_err err;
    struct args a;
    int rc = parse(&a, argc, argv);

    if (rc != 0)
        return rc == DX_ARG_E_HELP ? 0 : 2;
    dx_report_init(&report, a.format, "dexel bench live", argc, argv);
    for (uint32_t k = 0; rc == 0 && k < a.n_steps; k++)
        rc = run_step(&a, a.step[k], &live, &stages, &err);
    if (rc < 0)
        fprintf(stderr, "dexel bench live: %s\n", err.text);
    dx_report_table(&report, &live);
    if (a.control)
        dx_report_table(&report, &stages);
    return dx_report_close(&report) < 0 || rc < 0 ? 1 : 0;
}
