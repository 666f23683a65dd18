/* Putting the service together, in order, and apart, in reverse. */
#include "daemon/service.h"

#include "daemon/clock.h"
#include "daemon/log.h"
#include "daemon/server.h"
#include "daemon/stream.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <string.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#define JOIN_NS 700000000u /* for readers to come back from a decode, or from stopping a device */

struct service {
    struct dx_pool *pool;
    struct dx_server *server;
    struct dx_stream *stream[DX_CONFIG_MAX_STREAMS];
    uint32_t n_streams;
};

/* The loop takes the two by signalfd, so every thread must have them blocked; a client that goes
 * while it is written to is an error of the write. */
static void block_signals(void)
{
    sigset_t set;

    sigemptyset(&set);
    sigaddset(&set, SIGTERM);
    sigaddset(&set, SIGINT);
    pthread_sigmask(SIG_BLOCK, &set, NULL);
    signal(SIGPIPE, SIG_IGN);
}

/* A descriptor 0 to 2 that is not open would become a socket, and a log line its bytes. */
static void hold_standard_descriptors(void)
{
    for (int fd = 0; fd <= 2; fd++)
        if (fcntl(fd, F_GETFD) < 0 && open("/dev/null", O_RDWR) < 0)
            return;
}

static int open_streams(struct service *s, const struct dx_config *config, struct dx_err *err)
{
    for (uint32_t k = 0; k < config->n_streams; k++) {
        int r = dx_stream_new(&s->stream[k], &config->streams[k], s->pool, err);

        if (r < 0)
            return r;
        s->n_streams++;
    }
    return 0;
}

static int open_server(struct service *s, const struct dx_config *config, struct dx_err *err)
{
    struct dx_server_options options = {.mesh_path = config->socket,
                                        .control_path = config->control_socket,
                                        .max_clients = config->max_clients,
                                        .signals = true};
    int r = dx_server_new(&s->server, &options, err);

    for (uint32_t k = 0; r == 0 && k < s->n_streams; k++) {
        const struct dx_stream_config *c = dx_stream_config(s->stream[k]);
        struct dx_server_stream_options stream = {.name = c->name,
                                                  .feed = dx_stream_feed(s->stream[k]),
                                                  .counters = dx_stream_counters(s->stream[k]),
                                                  .lossless = c->lossless,
                                                  .recorder = dx_stream_recorder(s->stream[k]),
                                                  .player = dx_stream_player(s->stream[k]),
                                                  .reader = dx_stream_reader(s->stream[k]),
                                                  .beats = dx_stream_beats(s->stream[k]),
                                                  .subscribers = dx_stream_subscribers,
                                                  .ctx = s->stream[k]};

        r = dx_server_add_stream(s->server, &stream);
        if (r < 0)
            dx_err_set(err, r, "stream %s: %s", c->name, strerror(-r));
    }
    return r;
}

static void tell_ready(int ready_fd)
{
    sd_notify(0, "READY=1");
    if (ready_fd < 0)
        return;
    if (write(ready_fd, "ready\n", 6) < 0)
        dx_log_warning("service", "--ready-fd %d: %s", ready_fd, strerror(errno));
    close(ready_fd);
}

static int serve(struct service *s, int ready_fd, struct dx_err *err)
{
    int r = 0;

    for (uint32_t k = 0; r == 0 && k < s->n_streams; k++)
        r = dx_stream_start(s->stream[k], err);
    if (r < 0)
        return r;
    tell_ready(ready_fd);
    r = dx_server_run(s->server);
    sd_notify(0, "STOPPING=1");
    return r < 0 ? dx_err_set(err, r, "the loop: %s", strerror(-r)) : 0;
}

/* Threads first: nobody publishes any more. Then the loop's side of the feeds, then the feeds.
 * False: a reader did not come back in time, and what it uses stays. */
static bool take_down(struct service *s)
{
    uint64_t due_ns = dx_clock_ns() + JOIN_NS;
    bool joined = true;

    for (uint32_t k = 0; k < s->n_streams; k++)
        dx_stream_stop(s->stream[k]);
    for (uint32_t k = 0; k < s->n_streams; k++)
        joined &= dx_stream_join(s->stream[k], due_ns);
    dx_server_free(s->server);
    if (!joined)
        return false;
    for (uint32_t k = 0; k < s->n_streams; k++)
        dx_stream_free(s->stream[k]);
    dx_pool_free(s->pool);
    return true;
}

int dx_service_run(const struct dx_config *config, int ready_fd, struct dx_err *err)
{
    struct service s = {0};
    int r;

    hold_standard_descriptors();
    block_signals();
    dx_log_set_level(config->log_level);
    r = dx_pool_new(&s.pool, config->threads);
    if (r < 0) {
        dx_err_set(err, r, "the pool of threads: %s", strerror(-r));
    } else {
        r = open_streams(&s, config, err);
        if (r == 0)
            r = open_server(&s, config, err);
        if (r == 0)
            r = serve(&s, ready_fd, err);
    }
    if (take_down(&s))
        return r;
    dx_log_warning("service",
                   "a reader is still in a decode, or waits for its device: not waited for");
    return r < 0 ? r : DX_SERVICE_E_LEFT;
}
