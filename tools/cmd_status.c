/*
 * dexel status: what a running dexeld says about its streams and clients, as a table, or as the
 * JSON line that it sent. A field that is missing shows as "-", so that service and tool need not
 * be of one version.
 */
#include "tools/args.h"
#include "tools/cmd.h"
#include "tools/control_client.h"

#include <errno.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char help[] =
    "usage: dexel status [--socket PATH] [--json] [--watch]\n"
    "Shows the streams and clients of a running dexeld.\n\n"
    "  --socket PATH  control socket, or a mesh socket with one beside it (PATH.control);\n"
    "                 default $DEXELD_CONTROL, else /run/dexeld/control.sock\n"
    "  --json         the service's own line\n"
    "  --watch        again every second, until interrupted\n";

/* ---- cells
 * ---------------------------------------------------------------------------------------- */

/* A number at "key" or "key.member"; NAN where there is none. */
static double number(const json_t *o, const char *key, const char *member)
{
    const json_t *v = json_object_get(o, key);

    if (member)
        v = json_object_get(v, member);
    return json_is_number(v) ? json_number_value(v) : (double)NAN;
}

static const char *text(const json_t *o, const char *key)
{
    const char *s = json_string_value(json_object_get(o, key));

    return s && *s ? s : "-";
}

static void cell_text(FILE *f, int width, const char *s)
{
    fprintf(f, "%-*s ", width, s);
}

static void cell(FILE *f, int width, int decimals, double v)
{
    if (isnan(v))
        fprintf(f, "%*s ", width, "-");
    else
        fprintf(f, "%*.*f ", width, decimals, v);
}

/* 1234567 as 1.23M: counts that only grow. */
static void cell_count(FILE *f, int width, double v)
{
    static const char units[] = " kMGTP";
    int k = 0;

    while (v >= 100000 && k < 5) {
        v /= 1000;
        k++;
    }
    if (isnan(v))
        fprintf(f, "%*s ", width, "-");
    else if (k == 0)
        fprintf(f, "%*.0f ", width, v);
    else
        fprintf(f, "%*.*f%c ", width - 1, v < 100 ? 2 : 1, v, units[k]);
}

/* ---- tables
 * --------------------------------------------------------------------------------------- */

static void put_stream(FILE *f, const json_t *s)
{
    char size[32] = "-";
    double width = number(s, "width", NULL), height = number(s, "height", NULL);
    double drops = number(s, "drops", "mailbox"), corrupt = number(s, "drops", "corrupt");

    if (!isnan(width) && !isnan(height))
        snprintf(size, sizeof(size), "%.0fx%.0f", width, height);
    cell_text(f, 16, text(s, "name"));
    cell_text(f, 8, text(s, "state"));
    cell_text(f, 9, text(s, "geometry"));
    cell_text(f, 11, size);
    cell(f, 6, 1, number(s, "fps", NULL));
    cell_count(f, 8, number(s, "frames", NULL));
    cell_count(f, 8, number(s, "epochs", NULL));
    cell_count(f, 8, number(s, "tiles_sent", NULL));
    cell_count(f, 7, drops);
    cell_count(f, 7, corrupt);
    cell(f, 6, 1, 100 * number(s, "valid", NULL));
    cell(f, 8, 1, number(s, "mesh_ns_per_dexel", NULL));
    cell(f, 7, 2, number(s, "latency_ms", "p50"));
    cell(f, 7, 2, number(s, "latency_ms", "p99"));
    fputs(strcmp(text(s, "reason"), "-") == 0 ? "" : text(s, "reason"), f);
    fputc('\n', f);
}

static void put_device(FILE *f, const json_t *s)
{
    static const char *const counts[] = {"opens",  "unplugged", "stalls",
                                         "faults", "lost",      "damaged"};
    const json_t *d = json_object_get(s, "device");

    cell_text(f, 16, text(s, "name"));
    cell_text(f, 9, text(d, "state"));
    cell(f, 9, 0, number(d, "since_s", NULL));
    for (size_t k = 0; k < sizeof(counts) / sizeof(counts[0]); k++)
        cell_count(f, 9, number(d, counts[k], NULL));
    cell_text(f, 16, text(d, "serial"));
    fprintf(f, "%s%s", text(d, "place"), strcmp(text(d, "trouble"), "-") == 0 ? "" : ": ");
    fputs(strcmp(text(d, "trouble"), "-") == 0 ? "" : text(d, "trouble"), f);
    fputc('\n', f);
}

/* Nothing when no stream has a device. */
static void put_devices(FILE *f, const json_t *streams)
{
    bool any = false;

    for (size_t k = 0; k < json_array_size(streams); k++) {
        const json_t *s = json_array_get(streams, k);

        if (!json_object_get(s, "device"))
            continue;
        if (!any)
            fprintf(f, "\n%-16s %-9s %9s %9s %9s %9s %9s %9s %9s %-16s %s\n", "STREAM", "DEVICE",
                    "FOR S", "OPENS", "UNPLUGGED", "STALLS", "FAULTS", "LOST", "DAMAGED", "SERIAL",
                    "PLACE");
        any = true;
        put_device(f, s);
    }
}

static void put_client(FILE *f, const json_t *c)
{
    cell(f, 8, 0, number(c, "pid", NULL));
    cell(f, 6, 0, number(c, "uid", NULL));
    cell_text(f, 16, text(c, "stream"));
    cell_text(f, 8, text(c, "encoding"));
    cell_text(f, 8, text(c, "mode"));
    cell_count(f, 8, number(c, "epochs", NULL));
    cell_count(f, 9, number(c, "coalesced", NULL));
    cell_count(f, 6, number(c, "resets", NULL));
    cell_count(f, 10, number(c, "bytes", NULL));
    fputc('\n', f);
}

static void put_table(FILE *f, const json_t *reply)
{
    const json_t *streams = json_object_get(reply, "streams");
    const json_t *clients = json_object_get(reply, "clients");

    fprintf(f, "%-16s %-8s %-9s %-11s %6s %8s %8s %8s %7s %7s %6s %8s %7s %7s\n", "STREAM", "STATE",
            "GEOMETRY", "SIZE", "FPS", "FRAMES", "EPOCHS", "TILES", "SKIPPED", "CORRUPT", "VALID%",
            "NS/DEXEL", "P50 MS", "P99 MS");
    for (size_t k = 0; k < json_array_size(streams); k++)
        put_stream(f, json_array_get(streams, k));
    put_devices(f, streams);
    fprintf(f, "\n%8s %6s %-16s %-8s %-8s %8s %9s %6s %10s\n", "PID", "UID", "STREAM", "ENCODING",
            "MODE", "EPOCHS", "COALESCED", "RESETS", "BYTES");
    for (size_t k = 0; k < json_array_size(clients); k++)
        put_client(f, json_array_get(clients, k));
    if (json_array_size(clients) == 0)
        fputs("       - no clients\n", f);
    if (!isnan(number(reply, "rss_bytes", NULL)))
        fprintf(f, "\nmemory %.1f MB\n", number(reply, "rss_bytes", NULL) * 1e-6);
}

/* ---- asking
 * --------------------------------------------------------------------------------------- */

struct args {
    const char *socket;
    bool json, watch;
};

static int put_line(const char *line)
{
    return printf("%s\n", line) < 0 || fflush(stdout) != 0 ? -EIO : 0;
}

/* On a terminal a watched table stays in its place. */
static int put_reply(const char *line, const char *path, bool in_place, struct dx_err *err)
{
    json_error_t where;
    json_t *reply = json_loads(line, 0, &where);
    const char *refused = json_string_value(json_object_get(reply, "error"));
    int rc = 0;

    if (!json_is_object(reply))
        rc = dx_err_set(err, -EBADMSG, "%s: found '%.40s', expected a JSON object", path, line);
    else if (refused)
        rc = dx_err_set(err, -EBADMSG, "%s: the service: %s", path, refused);
    if (rc == 0) {
        if (in_place)
            fputs("\033[H\033[2J", stdout);
        put_table(stdout, reply);
        rc = fflush(stdout) != 0 ? dx_err_set(err, -EIO, "standard output cannot be written") : 0;
    }
    json_decref(reply);
    return rc;
}

static int show(const struct args *a, const char *path, struct dx_err *err)
{
    char *line;
    int rc = dx_control_ask(&line, path, "{\"request\":\"status\"}", err);

    if (rc < 0)
        return rc;
    if (a->json)
        rc = put_line(line) < 0 ? dx_err_set(err, -EIO, "standard output cannot be written") : 0;
    else
        rc = put_reply(line, path, a->watch && isatty(STDOUT_FILENO), err);
    free(line);
    return rc;
}

static int parse(struct args *a, int argc, char **argv)
{
    enum { OPT_SOCKET = 256, OPT_JSON, OPT_WATCH, OPT_HELP };
    static const struct option options[] = {
        {"socket", required_argument, NULL, OPT_SOCKET},
        {"json", no_argument, NULL, OPT_JSON},
        {"watch", no_argument, NULL, OPT_WATCH},
        {"help", no_argument, NULL, OPT_HELP},
        {0},
    };
    int opt;

    while ((opt = getopt_long(argc, argv, "", options, NULL)) != -1) {
        if (opt == OPT_HELP)
            return dx_arg_help(help);
        if (opt != OPT_SOCKET && opt != OPT_JSON && opt != OPT_WATCH)
            return -EINVAL;
        a->socket = opt == OPT_SOCKET ? optarg : a->socket;
        a->json |= opt == OPT_JSON;
        a->watch |= opt == OPT_WATCH;
    }
    if (optind < argc) {
        fprintf(stderr, "dexel status: found '%s', expected options only\n", argv[optind]);
        return -EINVAL;
    }
    return 0;
}

int cmd_status(int argc, char **argv)
{
    struct args a = {0};
    struct dx_err err;
    char path[108];
    int rc = parse(&a, argc, argv);

    if (rc != 0)
        return rc == DX_ARG_E_HELP ? 0 : 2;
    rc = dx_control_path(path, a.socket, &err);
    while (rc == 0) {
        rc = show(&a, path, &err);
        if (rc < 0 || !a.watch)
            break;
        sleep(1);
    }
    if (rc < 0)
        fprintf(stderr, "dexel status: %s\n", err.text);
    return rc < 0 ? 1 : 0;
}
