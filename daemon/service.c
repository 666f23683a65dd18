/* Putting the service together, in order, and apart, in reverse. */
#include "daemon/service.h"

#include "daemon/clock.h"
#include "daemon/log.h"
#include "daemon/notify.h"
#include "daemon/reload.h"
#include "daemon/server.h"
#include "daemon/service_open.h"
#include "daemon/service_streams.h"

#include <errno.h>
#include <fcntl.h>
#include <malloc.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define MMAP_FROM (32 << 10) /* bytes: what a stream is made of, and a subscriber */
#define JOIN_NS   700000000u /* for readers to come back from a decode, or from stopping a device */

struct service {
    struct dx_pool *pool;
    struct dx_server *server;
    struct dx_stream_list streams;
    struct dx_reload *reload; /* NULL: there is no file */
    const struct dx_config *config;
};

/* The loop takes the three by signalfd, so every thread must have them blocked; a client that goes
 * while it is written to is an error of the write. */
static void block_signals(void)
{
    sigset_t set;

    sigemptyset(&set);
    sigaddset(&set, SIGTERM);
    sigaddset(&set, SIGINT);
    sigaddset(&set, SIGHUP);
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

static uint64_t reload(void *service)
{
    struct service *s = service;

    return s->reload ? dx_reload_ask(s->reload) : 0;
}

static bool reload_waits(void *service, char stream[64])
{
    struct service *s = service;

    return s->reload && dx_reload_waits(s->reload, stream);
}

static char *config_text(void *service)
{
    const struct service *s = service;
    char *text = NULL;
    size_t len;
    FILE *out = open_memstream(&text, &len);

    if (!out)
        return NULL;
    dx_config_print_in_force(out, s->config, dx_log_level());
    if (fclose(out) == 0)
        return text;
    free(text);
    return NULL;
}

static void note_inherited(const struct service *s, struct dx_config *config)
{
    bool mesh, control;

    dx_server_inherits(s->server, &mesh, &control);
    if (mesh)
        dx_config_note_inherited(config, "socket");
    if (control)
        dx_config_note_inherited(config, "control_socket");
}

static int open_server(struct service *s, struct dx_config *config, struct dx_err *err)
{
    struct dx_server_options options = {.mesh_path = config->socket,
                                        .control_path = config->control_socket,
                                        .limits = dx_service_limits(config),
                                        .metrics_file = config->metrics_file,
                                        .metrics_s = config->metrics_s,
                                        .signals = true,
                                        .reload = reload,
                                        .reload_waits = reload_waits,
                                        .config = config_text,
                                        .ctx = s};
    int r = dx_server_new(&s->server, &options, err);

    if (r == 0)
        note_inherited(s, config);
    for (uint32_t k = 0; r == 0 && k < s->streams.n; k++) {
        struct dx_server_stream_options shows = dx_service_shows(s->streams.stream[k]);

        r = dx_server_add_stream(s->server, &shows);
        if (r < 0)
            dx_err_set(err, r, "stream %s: %s", shows.name, strerror(-r));
    }
    return r;
}

static int open_reload(struct service *s, struct dx_config *config, const char *file,
                       struct dx_err *err)
{
    const struct dx_reload_options options = {.file = file,
                                              .server = s->server,
                                              .pool = s->pool,
                                              .config = config,
                                              .streams = &s->streams};
    int r = file ? dx_reload_new(&s->reload, &options) : 0;

    return r < 0 ? dx_err_set(err, r, "event loop: %s", strerror(-r)) : 0;
}

static void log_start(const struct service *s, const char *file)
{
    char mesh[DX_SERVER_PATH], control[DX_SERVER_PATH];

    dx_server_paths(s->server, mesh, control);
    dx_log_notice("service", "version " DEXELD_VERSION ", %s: %u stream%s; mesh %s, control %s",
                  file ? file : "the command line", s->streams.n, s->streams.n == 1 ? "" : "s",
                  mesh, control);
}

static void tell_ready(const struct service *s, int ready_fd)
{
    dx_notify_ready(s->server);
    if (ready_fd < 0)
        return;
    if (write(ready_fd, "ready\n", 6) < 0)
        dx_log_warning("service", "--ready-fd %d: %s", ready_fd, strerror(errno));
    close(ready_fd);
}

static int serve(struct service *s, const char *file, int ready_fd, struct dx_err *err)
{
    int r = 0;

    for (uint32_t k = 0; r == 0 && k < s->streams.n; k++)
        r = dx_stream_start(s->streams.stream[k], err);
    if (r < 0)
        return r;
    log_start(s, file);
    tell_ready(s, ready_fd);
    r = dx_server_run(s->server);
    dx_notify_stopping();
    return r < 0 ? dx_err_set(err, r, "the loop: %s", strerror(-r)) : 0;
}

/* Threads first: nobody publishes any more. Then the loop's side of the feeds, then the feeds.
 * False: a reader did not come back in time, and what it uses stays. */
static bool take_down(struct service *s)
{
    uint64_t due_ns = dx_clock_ns() + JOIN_NS;
    bool joined;

    for (uint32_t k = 0; k < s->streams.n; k++)
        dx_stream_stop(s->streams.stream[k]);
    joined = dx_reload_end(s->reload, due_ns);
    for (uint32_t k = 0; k < s->streams.n; k++)
        joined &= dx_stream_join(s->streams.stream[k], due_ns);
    if (joined)
        dx_reload_free(s->reload);
    dx_server_free(s->server);
    if (!joined)
        return false;
    for (uint32_t k = 0; k < s->streams.n; k++)
        dx_stream_free(s->streams.stream[k]);
    dx_pool_free(s->pool);
    return true;
}

int dx_service_run(struct dx_config *config, const char *file, int ready_fd, struct dx_err *err)
{
    struct service s = {.config = config};
    int r;

    hold_standard_descriptors();
    /* What goes at a reload goes back to the system, whichever thread took it: malloc would keep it
     * for threads that are no more. */
    mallopt(M_MMAP_THRESHOLD, MMAP_FROM);
    block_signals();
    dx_log_set_level(config->log_level);
    r = dx_pool_new(&s.pool, config->threads);
    if (r < 0) {
        dx_err_set(err, r, "the pool of threads: %s", strerror(-r));
    } else {
        r = dx_service_open(&s.streams, config, file, s.pool, err);
        if (r == DX_SERVICE_E_LEFT)
            return r;
        if (r == 0)
            r = open_server(&s, config, err);
        if (r == 0)
            r = open_reload(&s, config, file, err);
        if (r == 0)
            r = serve(&s, file, ready_fd, err);
    }
    if (take_down(&s))
        return r;
    dx_log_warning("service",
                   "a reader is still in a decode, or waits for its device: not waited for");
    return r < 0 ? r : DX_SERVICE_E_LEFT;
}
