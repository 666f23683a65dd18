/*
 * dexel cat: the reference client. Subscribes to a stream through libdexel, holds the mesh as the
 * set of tiles that it is, and writes it when the stream ends, after so many commits, or when
 * interrupted. One thread.
 */
#include "tools/args.h"
#include "tools/cat_args.h"
#include "tools/now.h"
#include "tools/cmd.h"
#include "tools/mesh_split.h"
#include "tools/mesh_store.h"
#include "tools/out_mesh.h"
#include "tools/stats_json.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Values of callbacks that stop the connection. */
#define DONE   1 /* all is well */
#define FAILED 2 /* and it has been said why */

struct cat {
    struct dx_cat_args args;

    /* received */
    struct dexel *connection;
    struct dx_mesh_store *mesh;
    struct dexel_stream stream; /* name is not kept */
    struct dexel_commit last;
    uint64_t n_commits, n_bytes, n_missed;
    double latency_ms, worst_latency_ms;
    bool owed; /* a NEXT is on its way */

    uint64_t start_ns, shown_ns;
    uint64_t shown_commits, shown_bytes;
    bool live_line;
};

static volatile sig_atomic_t interrupted;

static void on_signal(int signal_number)
{
    (void)signal_number;
    interrupted = 1;
}

static const char *model_name(enum dexel_model model)
{
    switch (model) {
    case DEXEL_SPINNING:
        return "spinning";
    case DEXEL_PINHOLE:
        return "pinhole";
    case DEXEL_TABLE:
        return "table";
    }
    return "unknown";
}

static int fail(const char *what, int rc)
{
    fprintf(stderr, "dexel cat: %s: %s\n", what, strerror(-rc));
    return FAILED;
}

/* ---- output
 * --------------------------------------------------------------------------------------- */

/* `out` with the number where %06d stands, else before the extension. */
static char *numbered(const char *out, uint64_t number)
{
    const char *mark = strstr(out, "%06d"), *rest = mark ? mark + 4 : strrchr(out, '.');
    char *path;

    if (asprintf(&path, "%.*s%s%06llu%s", (int)((mark ? mark : rest) - out), out, mark ? "" : "-",
                 (unsigned long long)number, rest) < 0)
        return NULL;
    return path;
}

static int write_mesh(const struct cat *cat, const struct dx_mesh *mesh)
{
    char *path =
        cat->args.every ? numbered(cat->args.out, cat->n_commits - 1) : strdup(cat->args.out);
    struct dx_out_options options = {.world = cat->args.world};
    struct dx_err err = {.text = "out of memory"};
    int rc;

    memcpy(options.pose, cat->stream.pose, sizeof(options.pose));
    rc = path ? dx_out_mesh(path, mesh, &options, &err) : -ENOMEM;
    if (rc < 0)
        fprintf(stderr, "dexel cat: %s\n", err.text);
    free(path);
    return rc;
}

/* The mesh that the last commit has made; having said why there is none. */
static int weld(struct dx_mesh *mesh, const struct cat *cat)
{
    int rc = dx_mesh_store_weld(mesh, cat->mesh);

    if (rc == 0 && cat->args.split)
        rc = dx_mesh_split(mesh) < 0 ? -ENOMEM : 0;
    if (rc < 0)
        fprintf(stderr, "dexel cat: the mesh: %s\n", strerror(-rc));
    return rc;
}

static int weld_and_write(const struct cat *cat)
{
    struct dx_mesh mesh;
    int rc = weld(&mesh, cat);

    if (rc == 0)
        rc = write_mesh(cat, &mesh);
    dx_mesh_fini(&mesh);
    return rc;
}

/* On a terminal one line that is written over, five times a second. */
static void show_rates(struct cat *cat)
{
    uint64_t now = dx_now_ns();
    double s = (double)(now - cat->shown_ns) * 1e-9;

    if (!cat->live_line || s < 0.2)
        return;
    fprintf(stderr, "\r\033[K%.1f frames/s  %.2f MB/s  %llu triangles  latency %.1f ms",
            (double)(cat->n_commits - cat->shown_commits) / s,
            (double)(cat->n_bytes - cat->shown_bytes) / s * 1e-6,
            (unsigned long long)dx_mesh_store_n_triangles(cat->mesh), cat->latency_ms);
    cat->shown_ns = now;
    cat->shown_commits = cat->n_commits;
    cat->shown_bytes = cat->n_bytes;
}

static void show_total(const struct cat *cat, double seconds)
{
    if (cat->args.quiet)
        return;
    fprintf(stderr, "%s%llu commits, %llu triangles, %.2f MB in %.2f s (%.1f frames/s), ",
            cat->live_line ? "\r\033[K" : "", (unsigned long long)cat->n_commits,
            (unsigned long long)dx_mesh_store_n_triangles(cat->mesh), (double)cat->n_bytes * 1e-6,
            seconds, seconds > 0 ? (double)cat->n_commits / seconds : 0);
    fprintf(stderr, "%llu frames missed, latency %.1f ms (worst %.1f)\n",
            (unsigned long long)cat->n_missed, cat->latency_ms, cat->worst_latency_ms);
}

static int print_stats(const struct cat *cat, const struct dx_mesh *mesh, double seconds)
{
    struct dx_mesh_stats stats;
    json_t *o;
    int rc = dx_mesh_stats_compute(&stats, mesh);

    if (rc < 0)
        return fail("the statistics", rc);
    o = dx_stats_json(&stats);
    json_object_set_new(o, "seconds", json_real(seconds));
    json_object_set_new(o, "geometry", json_string(model_name(cat->stream.model)));
    json_object_set_new(o, "width", json_integer(cat->stream.width));
    json_object_set_new(o, "height", json_integer(cat->stream.height));
    json_object_set_new(o, "sigma", dx_sigma_json(cat->stream.sigma));
    json_object_set_new(o, "smoothed", json_boolean(cat->stream.smoothed));
    json_object_set_new(o, "commits", json_integer((json_int_t)cat->n_commits));
    json_object_set_new(o, "frame", json_integer((json_int_t)cat->last.frame));
    json_object_set_new(o, "frames_missed", json_integer((json_int_t)cat->n_missed));
    json_object_set_new(o, "dropped", json_integer((json_int_t)cat->last.n_dropped));
    json_object_set_new(o, "bytes", json_integer((json_int_t)cat->n_bytes));
    json_object_set_new(
        o, "latency_ms",
        json_pack("{s:f, s:f}", "last", cat->latency_ms, "worst", cat->worst_latency_ms));
    return dx_json_print(o, "dexel cat");
}

/* ---- what the service says
 * ------------------------------------------------------------------------- */

static int ask_next(struct cat *cat)
{
    if (cat->args.subscribe.mode != DEXEL_PULL || cat->owed)
        return 0;
    cat->owed = true;
    return dexel_next(cat->connection);
}

static int on_stream(void *user, const struct dexel_stream *stream)
{
    struct cat *cat = user;
    struct dx_mesh_store *mesh;
    int rc = dx_mesh_store_new(&mesh, stream->height, stream->width, stream->wrap,
                               (uint8_t)stream->attr_bytes);

    if (rc < 0)
        return fail("the mesh", rc);
    dx_mesh_store_free(cat->mesh);
    cat->mesh = mesh;
    cat->stream = *stream;
    if (!cat->args.quiet)
        fprintf(stderr, "%s%s: %s, %u x %u dexels, unit %g mm%s\n",
                cat->live_line ? "\r\033[K" : "", stream->name, model_name(stream->model),
                stream->width, stream->height, stream->unit_m * 1e3,
                stream->smoothed ? ", smoothed" : "");
    return ask_next(cat);
}

static int on_reset(void *user, const char *reason)
{
    struct cat *cat = user;

    if (!cat->args.quiet)
        fprintf(stderr, "%sreset: %s\n", cat->live_line ? "\r\033[K" : "", reason);
    if (cat->mesh)
        dx_mesh_store_reset(cat->mesh);
    cat->owed = false;
    return 0;
}

static int on_raw_tile(void *user, const uint8_t *chunk, size_t len)
{
    (void)chunk;
    ((struct cat *)user)->n_bytes += len;
    return 0;
}

static int on_tile(void *user, const struct dexel_tile *tile)
{
    struct cat *cat = user;
    int rc = dx_mesh_store_set(cat->mesh, &(struct dx_store_tile){.row = tile->row,
                                                                  .col = tile->col,
                                                                  .n_vertices = tile->n_vertices,
                                                                  .n_triangles = tile->n_triangles,
                                                                  .xyz = tile->xyz,
                                                                  .index = tile->index,
                                                                  .id = tile->dexel,
                                                                  .attr = tile->attr,
                                                                  .normal = tile->normal});

    return rc < 0 ? fail("a tile", rc) : 0;
}

static int on_commit(void *user, const struct dexel_commit *commit)
{
    struct cat *cat = user;

    dx_mesh_store_set_caps(cat->mesh, commit->cap_first, commit->cap_last, cat->stream.flip);
    dx_mesh_store_commit(cat->mesh);
    if (cat->n_commits && commit->frame > cat->last.frame + 1)
        cat->n_missed += commit->frame - cat->last.frame - 1;
    cat->last = *commit;
    cat->n_commits++;
    cat->owed = false;
    cat->latency_ms = (double)((int64_t)dx_now_ns() - (int64_t)commit->host_ns) * 1e-6;
    if (cat->latency_ms > cat->worst_latency_ms)
        cat->worst_latency_ms = cat->latency_ms;
    show_rates(cat);
    if (cat->args.every && weld_and_write(cat) < 0)
        return FAILED;
    if (cat->n_commits == cat->args.n_frames)
        return DONE;
    return ask_next(cat);
}

static int on_state(void *user, enum dexel_state state, const char *reason)
{
    static const char *const names[] = {"opening", "live", "stalled", "gone", "ended", "faulted"};
    struct cat *cat = user;

    if (!cat->args.quiet && state > DEXEL_LIVE_STATE && state <= DEXEL_FAULTED)
        fprintf(stderr, "%s%s%s%s\n", cat->live_line ? "\r\033[K" : "", names[state],
                *reason ? ": " : "", reason);
    return state == DEXEL_ENDED ? DONE : 0;
}

/* ---- running
 * --------------------------------------------------------------------------------------- */

/* Signals come only while we wait (ppoll's mask), so that none is lost between the test and the
 * wait. */
static int receive(struct cat *cat)
{
    struct timespec timeout = {.tv_sec = (time_t)cat->args.timeout_s};
    sigset_t block, wait;
    int rc;

    timeout.tv_nsec = (long)((cat->args.timeout_s - (double)timeout.tv_sec) * 1e9);
    sigemptyset(&block);
    sigaddset(&block, SIGINT);
    sigaddset(&block, SIGTERM);
    sigprocmask(SIG_BLOCK, &block, &wait);
    sigaction(SIGINT, &(struct sigaction){.sa_handler = on_signal}, NULL);
    sigaction(SIGTERM, &(struct sigaction){.sa_handler = on_signal}, NULL);
    while ((rc = dexel_dispatch(cat->connection)) == 0) {
        struct pollfd p = {.fd = dexel_fd(cat->connection),
                           .events = dexel_events(cat->connection)};

        rc = ppoll(&p, 1, cat->args.timeout_s > 0 ? &timeout : NULL, &wait);
        if (interrupted)
            return DONE;
        if (rc == 0) {
            fprintf(stderr, "dexel cat: nothing from the service for %g s\n", cat->args.timeout_s);
            return FAILED;
        }
    }
    return rc;
}

/* What came to be by the end: the last lines, OUT, the statistics. */
static int finish(struct cat *cat)
{
    double seconds = dx_seconds_since(cat->start_ns);
    struct dx_mesh mesh;
    int rc;

    if (!cat->n_commits) {
        fprintf(stderr, "dexel cat: it ended before the first whole mesh\n");
        return -ENODATA;
    }
    show_total(cat, seconds);
    if (!cat->args.stats && (!cat->args.out || cat->args.every))
        return 0;
    rc = weld(&mesh, cat);
    if (rc == 0 && cat->args.stats)
        rc = print_stats(cat, &mesh, seconds);
    if (rc == 0 && cat->args.out && !cat->args.every)
        rc = write_mesh(cat, &mesh);
    dx_mesh_fini(&mesh);
    return rc;
}

static int run(struct cat *cat)
{
    static const struct dexel_callbacks callbacks = {
        .stream = on_stream,
        .reset = on_reset,
        .tile = on_tile,
        .raw_tile = on_raw_tile,
        .commit = on_commit,
        .state = on_state,
    };
    int rc, finished;

    cat->start_ns = cat->shown_ns = dx_now_ns();
    cat->live_line = !cat->args.quiet && isatty(STDERR_FILENO);
    rc = dexel_open(&cat->connection, &cat->args.subscribe, &callbacks, cat);
    if (rc == 0)
        rc = receive(cat);
    if (rc < 0)
        fprintf(stderr, "%sdexel cat: %s\n", cat->live_line ? "\r\033[K" : "",
                dexel_error(cat->connection));
    dexel_close(cat->connection);
    /* Also after an error: the last whole mesh is good, the exit status tells. */
    finished = rc == DONE || cat->n_commits ? finish(cat) : 0;
    dx_mesh_store_free(cat->mesh);
    return rc == DONE && finished == 0 ? 0 : 1;
}

int cmd_cat(int argc, char **argv)
{
    struct cat cat = {0};
    int rc = dx_cat_args_parse(&cat.args, argc, argv);

    if (rc != 0)
        return rc == DX_ARG_E_HELP ? 0 : 2;
    return run(&cat);
}
