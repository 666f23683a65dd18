/*
 * dexel status: what a running dexeld says about its streams and clients, as a table, as a live
 * screen, or as the JSON line that it sent. A field that is missing shows as "-", so that service
 * and tool need not be of one version.
 */
#include "tools/args.h"
#include "tools/cmd.h"
#include "tools/control_client.h"
#include "tools/recording_state.h"
#include "tools/status_member.h"
#include "tools/status_screen.h"
#include "tools/stdout.h"
#include "tools/terminal.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define PERIOD_MS 1000

static const char help[] =
    "usage: dexel status [--socket PATH] [--json] [--watch]\n"
    "Shows the streams and clients of a running dexeld.\n\n"
    "  --socket PATH  control socket, or a mesh socket with one beside it (PATH.control);\n"
    "                 default $DEXELD_CONTROL, else /run/dexeld/control.sock\n"
    "  --json         the service's own line\n"
    "  --watch        again every second; on a terminal as a live screen, with rates, which q\n"
    "                 ends; elsewhere until the service does not answer (status 1)\n";

/* ---- cells
 * ---------------------------------------------------------------------------------------- */

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
    double width = dx_status_number(s, "width", NULL), height = dx_status_number(s, "height", NULL);
    double drops = dx_status_number(s, "drops", "mailbox"),
           corrupt = dx_status_number(s, "drops", "corrupt");

    if (!isnan(width) && !isnan(height))
        snprintf(size, sizeof(size), "%.0fx%.0f", width, height);
    cell_text(f, 16, dx_status_text(s, "name"));
    cell_text(f, 8, dx_status_text(s, "state"));
    cell_text(f, 9, dx_status_text(s, "geometry"));
    cell_text(f, 11, size);
    cell(f, 6, 1, dx_status_number(s, "fps", NULL));
    cell_count(f, 8, dx_status_number(s, "frames", NULL));
    cell_count(f, 8, dx_status_number(s, "epochs", NULL));
    cell_count(f, 8, dx_status_number(s, "tiles_sent", NULL));
    cell_count(f, 7, drops);
    cell_count(f, 7, corrupt);
    cell(f, 6, 1, 100 * dx_status_number(s, "valid", NULL));
    cell(f, 8, 1, dx_status_number(s, "mesh_ns_per_dexel", NULL));
    cell(f, 7, 2, dx_status_number(s, "latency_ms", "p50"));
    cell(f, 7, 2, dx_status_number(s, "latency_ms", "p99"));
    fputs(strcmp(dx_status_text(s, "reason"), "-") == 0 ? "" : dx_status_text(s, "reason"), f);
    fputc('\n', f);
}

static void put_device(FILE *f, const json_t *s)
{
    static const char *const counts[] = {"opens",  "unplugged", "stalls",
                                         "faults", "lost",      "damaged"};
    const json_t *d = json_object_get(s, "device");

    cell_text(f, 16, dx_status_text(s, "name"));
    cell_text(f, 9, dx_status_text(d, "state"));
    cell(f, 9, 0, dx_status_number(d, "since_s", NULL));
    for (size_t k = 0; k < sizeof(counts) / sizeof(counts[0]); k++)
        cell_count(f, 9, dx_status_number(d, counts[k], NULL));
    cell_text(f, 16, dx_status_text(d, "serial"));
    fprintf(f, "%s%s", dx_status_text(d, "place"),
            strcmp(dx_status_text(d, "trouble"), "-") == 0 ? "" : ": ");
    fputs(strcmp(dx_status_text(d, "trouble"), "-") == 0 ? "" : dx_status_text(d, "trouble"), f);
    fputc('\n', f);
}

static void put_recording(FILE *f, const json_t *s)
{
    const json_t *r = json_object_get(s, "recording");
    const char *error = json_string_value(json_object_get(r, "error_text"));

    cell_text(f, 16, dx_status_text(s, "name"));
    cell_text(f, 9, dx_recording_state(r));
    cell_count(f, 9, dx_status_number(r, "blocks", NULL));
    cell_count(f, 9, dx_status_number(r, "dropped", NULL));
    cell_count(f, 9, dx_status_number(r, "files", NULL));
    cell(f, 9, 1, dx_status_number(r, "bytes", NULL) * 1e-6);
    fputs(dx_status_text(r, "path"), f);
    if (error)
        fprintf(f, ": %s", error);
    fputc('\n', f);
}

/* A line for each stream that has the member; nothing when none has it. */
static void put_those(FILE *f, const json_t *streams, const char *member, const char *head,
                      void (*put)(FILE *f, const json_t *stream))
{
    bool any = false;

    for (size_t k = 0; k < json_array_size(streams); k++) {
        const json_t *s = json_array_get(streams, k);

        if (!json_object_get(s, member))
            continue;
        if (!any)
            fprintf(f, "\n%s\n", head);
        any = true;
        put(f, s);
    }
}

static void put_devices(FILE *f, const json_t *streams)
{
    char head[128];

    snprintf(head, sizeof(head), "%-16s %-9s %9s %9s %9s %9s %9s %9s %9s %-16s %s", "STREAM",
             "DEVICE", "FOR S", "OPENS", "UNPLUGGED", "STALLS", "FAULTS", "LOST", "DAMAGED",
             "SERIAL", "PLACE");
    put_those(f, streams, "device", head, put_device);
}

static void put_recordings(FILE *f, const json_t *streams)
{
    char head[128];

    snprintf(head, sizeof(head), "%-16s %-9s %9s %9s %9s %9s %s", "STREAM", "RECORDING", "BLOCKS",
             "LOST", "FILES", "MB", "NEWEST");
    put_those(f, streams, "recording", head, put_recording);
}

static void put_client(FILE *f, const json_t *c)
{
    cell(f, 8, 0, dx_status_number(c, "pid", NULL));
    cell(f, 6, 0, dx_status_number(c, "uid", NULL));
    cell_text(f, 16, dx_status_text(c, "stream"));
    cell_text(f, 8, dx_status_text(c, "encoding"));
    cell_text(f, 8, dx_status_text(c, "mode"));
    cell_count(f, 8, dx_status_number(c, "epochs", NULL));
    cell_count(f, 9, dx_status_number(c, "coalesced", NULL));
    cell_count(f, 6, dx_status_number(c, "resets", NULL));
    cell_count(f, 10, dx_status_number(c, "bytes", NULL));
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
    put_recordings(f, streams);
    fprintf(f, "\n%8s %6s %-16s %-8s %-8s %8s %9s %6s %10s\n", "PID", "UID", "STREAM", "ENCODING",
            "MODE", "EPOCHS", "COALESCED", "RESETS", "BYTES");
    for (size_t k = 0; k < json_array_size(clients); k++)
        put_client(f, json_array_get(clients, k));
    if (json_array_size(clients) == 0)
        fputs("       - no clients\n", f);
    if (!isnan(dx_status_number(reply, "rss_bytes", NULL)))
        fprintf(f, "\nmemory %.1f MB\n", dx_status_number(reply, "rss_bytes", NULL) * 1e-6);
}

/* ---- asking
 * --------------------------------------------------------------------------------------- */

struct args {
    const char *socket;
    bool json, watch;
};

/* The service's answer, an object; `line` as it came. */
static int ask(json_t **reply, char **line, const char *path, struct dx_err *err)
{
    int rc = dx_control_ask(line, path, "{\"request\":\"status\"}", err);

    *reply = NULL;
    if (rc < 0)
        return rc;
    rc = dx_control_take(reply, *line, path, err);
    if (rc < 0)
        free(*line);
    return rc;
}

static int show(const struct args *a, const char *path, struct dx_err *err)
{
    json_t *reply;
    char *line;
    int rc = ask(&reply, &line, path, err);

    if (rc < 0)
        return rc;
    if (a->json)
        dx_stdout_put_line(line);
    else
        put_table(stdout, reply);
    *err->text = 0; /* main tells of standard output */
    rc = dx_stdout_flush();
    json_decref(reply);
    free(line);
    return rc;
}

/* A block a second, the blocks apart by an empty line. A service that does not answer ends it: who
 * reads a pipe or a file has no other way to learn that, and can ask again. */
static int show_again(const struct args *a, const char *path, struct dx_err *err)
{
    int rc = show(a, path, err);

    while (rc == 0) {
        sleep(1);
        if (!a->json)
            putchar('\n');
        rc = show(a, path, err);
    }
    return rc;
}

/* ---- the live screen
 * ------------------------------------------------------------------------------ */

/* A service that does not answer any more may come again: its last state stays, and why. */
static void draw(const json_t *now, const json_t *before, const char *trouble)
{
    struct dx_status_screen screen = {.colours = dx_terminal_has_colours(), .trouble = trouble};

    dx_terminal_size(&screen.columns, &screen.rows);
    dx_status_screen_put(stdout, &screen, now, before);
    fflush(stdout);
}

/* Until `q` or the end of standard input; a signal ends it as it would any program. */
static int show_live(const char *path, struct dx_err *err)
{
    json_t *now, *before = NULL;
    char *line;
    int rc = ask(&now, &line, path, err), key = DX_TERMINAL_NO_KEY;

    if (rc < 0)
        return rc;
    free(line);
    dx_terminal_enter();
    draw(now, before, NULL);
    while (key != 'q' && key != 'Q' && key != DX_TERMINAL_END) {
        json_t *next;

        key = dx_terminal_key(PERIOD_MS);
        if (key != DX_TERMINAL_NO_KEY)
            continue;
        if (ask(&next, &line, path, err) == 0) {
            free(line);
            json_decref(before);
            before = now;
            now = next;
            draw(now, before, NULL);
        } else {
            draw(now, NULL, err->text);
        }
    }
    dx_terminal_leave();
    json_decref(now);
    json_decref(before);
    return 0;
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
    if (rc == 0 && a.watch && !a.json && dx_terminal_is_there())
        rc = show_live(path, &err);
    else if (rc == 0)
        rc = a.watch ? show_again(&a, path, &err) : show(&a, path, &err);
    if (rc < 0 && *err.text)
        fprintf(stderr, "dexel status: %s\n", err.text);
    return rc < 0 ? 1 : 0;
}
