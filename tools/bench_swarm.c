/* Many subscribers in one thread: see bench_swarm.h. */
#include "tools/bench_swarm.h"

#include "tools/bench.h"
#include "tools/now.h"

#include <errno.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>

#define PATIENCE_S 30.0 /* for the first mesh of all */

struct follower {
    struct dx_swarm *swarm;
    struct dexel *connection;
    bool has_mesh;
    uint64_t epoch; /* of its last COMMIT */
};

struct dx_swarm {
    uint32_t n, n_with_mesh;
    struct follower *follower;
    struct pollfd *poll;
    bool measures, ended;
    struct dx_swarm_figures figures;
    uint64_t dropped_before, dropped; /* as the service counts, first and last */
    double *latency_ms;
    size_t n_latencies, room;
    bool no_memory;
};

/* ---- what comes -------------------------------------------------------------------------------
 */

static int on_stream(void *follower, const struct dexel_stream *stream)
{
    struct follower *f = follower;

    f->swarm->figures.grid_tiles = stream->tile_rows * stream->tile_cols;
    return 0;
}

static int on_reset(void *follower, const char *reason)
{
    struct follower *f = follower;

    (void)reason;
    f->swarm->figures.n_resets += f->swarm->measures;
    return 0;
}

static int on_raw_tile(void *follower, const uint8_t *chunk, size_t len)
{
    struct follower *f = follower;

    (void)chunk;
    f->swarm->figures.n_tiles += f->swarm->measures;
    f->swarm->figures.n_bytes += f->swarm->measures ? len : 0;
    return 0;
}

static int on_tile(void *follower, const struct dexel_tile *tile)
{
    (void)follower;
    (void)tile;
    return 0;
}

static void add_latency(struct dx_swarm *s, double ms)
{
    if (s->n_latencies == s->room) {
        size_t room = s->room ? 2 * s->room : 4096;
        double *more = realloc(s->latency_ms, room * sizeof(*more));

        if (!more) {
            s->no_memory = true;
            return;
        }
        s->latency_ms = more;
        s->room = room;
    }
    s->latency_ms[s->n_latencies++] = ms;
}

static int on_commit(void *follower, const struct dexel_commit *c)
{
    struct follower *f = follower;
    struct dx_swarm *s = f->swarm;
    uint64_t epoch = f->epoch;

    f->epoch = c->epoch;
    s->n_with_mesh += !f->has_mesh;
    f->has_mesh = true;
    if (!s->measures)
        return 0;
    if (!s->figures.n_commits++)
        s->dropped_before = c->n_dropped;
    s->dropped = c->n_dropped > s->dropped ? c->n_dropped : s->dropped;
    if (c->snapshot)
        return 0;
    s->figures.n_missed += c->epoch - epoch - 1;
    add_latency(s, (double)((int64_t)dx_now_ns() - (int64_t)c->host_ns) * 1e-6);
    return 0;
}

static int on_state(void *follower, enum dexel_state state, const char *reason)
{
    struct follower *f = follower;

    (void)reason;
    f->swarm->ended |= state == DEXEL_ENDED || state == DEXEL_GONE;
    return 0;
}

/* ---- receiving --------------------------------------------------------------------------------
 */

/* What is there for one of them. */
static int turn(struct dx_swarm *s, double timeout_s, struct dx_err *err)
{
    int n, rc;

    for (uint32_t k = 0; k < s->n; k++)
        s->poll[k].events = dexel_events(s->follower[k].connection);
    n = poll(s->poll, s->n, timeout_s < 0.1 ? (int)(timeout_s * 1000) + 1 : 100);
    if (n < 0 && errno != EINTR)
        return dx_err_set(err, -errno, "poll: %s", strerror(errno));
    for (uint32_t k = 0; n > 0 && k < s->n; k++) {
        if (!s->poll[k].revents)
            continue;
        rc = dexel_dispatch(s->follower[k].connection);
        if (rc < 0)
            return dx_err_set(err, rc, "subscriber %u: %s", k + 1,
                              dexel_error(s->follower[k].connection));
    }
    if (s->no_memory)
        return dx_err_set(err, -ENOMEM, "no memory");
    return 0;
}

static int await_meshes(struct dx_swarm *s, struct dx_err *err)
{
    uint64_t start = dx_now_ns();
    int rc = 0;

    while (rc == 0 && s->n_with_mesh < s->n) {
        double left = PATIENCE_S - dx_seconds_since(start);

        if (left <= 0 || s->ended)
            return dx_err_set(
                err, -ETIMEDOUT, "found a mesh at %u of %u subscribers %s, expected one at each",
                s->n_with_mesh, s->n, s->ended ? "at the stream's end" : "within 30 s");
        rc = turn(s, left, err);
    }
    return rc;
}

static int open_all(struct dx_swarm *s, const struct dx_swarm_options *o, struct dx_err *err)
{
    const struct dexel_callbacks callbacks = {.stream = on_stream,
                                              .reset = on_reset,
                                              .tile = o->decode ? on_tile : NULL,
                                              .raw_tile = on_raw_tile,
                                              .commit = on_commit,
                                              .state = on_state};

    for (uint32_t k = 0; k < s->n; k++) {
        struct follower *f = &s->follower[k];
        int rc;

        f->swarm = s;
        rc = dexel_open(&f->connection, &o->subscribe, &callbacks, f);
        if (rc < 0)
            return dx_err_set(err, rc, "subscriber %u: %s", k + 1, dexel_error(f->connection));
        s->poll[k].fd = dexel_fd(f->connection);
    }
    return await_meshes(s, err);
}

int dx_swarm_open(struct dx_swarm **out, const struct dx_swarm_options *options, struct dx_err *err)
{
    struct dx_swarm *s = calloc(1, sizeof(*s));
    int rc;

    if (!s)
        return dx_err_set(err, -ENOMEM, "no memory");
    s->n = options->n_subscribers;
    s->follower = calloc(s->n, sizeof(*s->follower));
    s->poll = calloc(s->n, sizeof(*s->poll));
    rc = s->follower && s->poll ? open_all(s, options, err) : dx_err_set(err, -ENOMEM, "no memory");
    if (rc < 0)
        dx_swarm_close(s);
    else
        *out = s;
    return rc;
}

void dx_swarm_close(struct dx_swarm *s)
{
    if (!s)
        return;
    for (uint32_t k = 0; s->follower && k < s->n; k++)
        dexel_close(s->follower[k].connection);
    free(s->latency_ms);
    free(s->poll);
    free(s->follower);
    free(s);
}

static void tell(struct dx_swarm *s, double seconds, struct dx_swarm_figures *figures)
{
    size_t n = s->n_latencies;

    qsort(s->latency_ms, n, sizeof(*s->latency_ms), dx_bench_by_value);
    s->figures.seconds = seconds;
    s->figures.n_dropped = s->dropped - s->dropped_before;
    s->figures.p50_ms = s->latency_ms[n / 2];
    s->figures.p99_ms = s->latency_ms[99 * n / 100];
    s->figures.max_ms = s->latency_ms[n - 1];
    *figures = s->figures;
}

int dx_swarm_run(struct dx_swarm *s, double seconds, struct dx_swarm_figures *figures,
                 struct dx_err *err)
{
    uint64_t start = dx_now_ns();
    double left = seconds;
    int rc = 0;

    s->figures = (struct dx_swarm_figures){.grid_tiles = s->figures.grid_tiles};
    s->n_latencies = 0;
    s->dropped = s->dropped_before = 0;
    s->measures = true;
    while (rc == 0 && left > 0 && !s->ended) {
        rc = turn(s, left, err);
        left = seconds - dx_seconds_since(start);
    }
    s->measures = false;
    if (rc == 0 && !s->n_latencies)
        rc = dx_err_set(err, -ENODATA, "found no new mesh within %g s, expected frames", seconds);
    if (rc == 0)
        tell(s, seconds - left, figures);
    return rc;
}
