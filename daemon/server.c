/*
 * The loop. Every event does its own work; then the post source looks at what that changed:
 * subscribers that can start a batch, feeds that can go on, connections to free, the next deadline.
 * Loop thread.
 */
#include "daemon/server_priv.h"

#include <assert.h>
#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "daemon/clock.h"
#include "daemon/control.h"
#include "daemon/limits.h"
#include "daemon/log.h"
#include "daemon/metrics_file.h"
#include "daemon/watchdog.h"

#define HELLO_NS       5000000000u
#define STALL_NS       10000000000u
#define TICK_NS        1000000000u
#define DRAIN_NS       300000000u /* for messages half written at the end */
#define ACCEPTS_A_TURN 16

/* ---- connections
 * --------------------------------------------------------------------------------- */

/* Its own words in an ERROR, if the socket takes it at once. Takes the descriptor. */
static void refuse_client(int fd, const struct ucred *who, const char *why)
{
    struct dx_msg_error m = {.code = DX_WIRE_E_LIMIT};
    uint8_t bytes[DX_WIRE_HEADER_LEN + 2 + 2 + DX_WIRE_TEXT];
    struct dx_writer w =
        dx_writer_init(bytes + DX_WIRE_HEADER_LEN, sizeof(bytes) - DX_WIRE_HEADER_LEN);
    struct dx_wire_header h = {.type = DX_MSG_ERROR, .stream = DX_WIRE_NO_STREAM};
    size_t len;

    snprintf(m.text, sizeof(m.text), "%s", why);
    dx_msg_error_put(&w, &m);
    len = (size_t)(w.p - bytes);
    h.length = (uint32_t)(len - DX_WIRE_HEADER_LEN);
    dx_wire_put_header(bytes, &h);
    if (send(fd, bytes, len, MSG_NOSIGNAL | MSG_DONTWAIT) < 0)
        dx_log_debug("server", "refused client: %s", strerror(errno));
    close(fd);
    dx_log_warning("server", "a client (pid %d uid %u) was refused: %s", (int)who->pid,
                   (unsigned)who->uid, why);
}

static void add_client(struct dx_server *s, int fd)
{
    struct ucred who = {0, (uid_t)-1, (gid_t)-1};
    socklen_t len = sizeof(who);
    struct dx_subscriber *sub;
    char why[DX_WIRE_TEXT];
    int r;

    (void)getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &who, &len);
    if (!dx_limits_admit(s, fd, &who, why)) {
        refuse_client(fd, &who, why);
        return;
    }
    r = dx_subscriber_new(&sub, s, fd, &who);
    if (r < 0) {
        dx_log_warning("server", "a client could not be taken in: %s", strerror(-r));
        return;
    }
    sub->next = s->subscribers;
    s->subscribers = sub;
    s->n_clients++;
}

static int on_accept(sd_event_source *source, int fd, uint32_t revents, void *server)
{
    struct dx_server *s = server;

    (void)revents;
    for (int k = 0; k < ACCEPTS_A_TURN; k++) {
        int client = accept4(fd, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);

        if (client >= 0) {
            add_client(s, client);
        } else if (errno == EAGAIN) {
            break;
        } else if (errno != EINTR && errno != ECONNABORTED) {
            /* out of descriptors or memory: the socket stays readable, so look away for a moment */
            dx_log_warning("server", "accept: %s", strerror(errno));
            sd_event_source_set_enabled(source, SD_EVENT_OFF);
            s->accept_again_ns = dx_clock_ns() + DX_SERVER_ACCEPT_PAUSE_NS;
            break;
        }
    }
    return 0;
}

static void reap(struct dx_server *s)
{
    struct dx_subscriber **at = &s->subscribers;

    while (*at) {
        struct dx_subscriber *sub = *at;

        if (sub->phase != DX_SUBSCRIBER_CLOSED) {
            at = &sub->next;
            continue;
        }
        *at = sub->next;
        s->n_clients--;
        dx_subscriber_free(sub);
    }
}

/* ---- time
 * ---------------------------------------------------------------------------------------- */

static void arm_timer(struct dx_server *s)
{
    uint64_t due = s->tick_due_ns;

    if (s->accept_again_ns && s->accept_again_ns < due)
        due = s->accept_again_ns;
    if (s->exit_due_ns && s->exit_due_ns < due)
        due = s->exit_due_ns;
    for (struct dx_subscriber *sub = s->subscribers; sub; sub = sub->next) {
        uint64_t its = dx_subscriber_due(sub);

        if (its < due)
            due = its;
    }
    sd_event_source_set_time(s->timer, due / 1000 + 1); /* microseconds; not before it is due */
    sd_event_source_set_enabled(s->timer, SD_EVENT_ONESHOT);
}

static int on_timer(sd_event_source *source, uint64_t usec, void *server)
{
    struct dx_server *s = server;
    uint64_t now = dx_clock_ns();

    (void)source;
    (void)usec;
    for (struct dx_subscriber *sub = s->subscribers; sub; sub = sub->next)
        dx_subscriber_tick(sub, now);
    if (s->accept_again_ns && now >= s->accept_again_ns) {
        s->accept_again_ns = 0;
        sd_event_source_set_enabled(s->mesh.io, SD_EVENT_ON);
    }
    if (now >= s->tick_due_ns) {
        s->tick_due_ns = now + TICK_NS;
        dx_control_resume(s->control);
        dx_server_tick_streams(s, now);
        dx_metrics_file_tick(s->metrics, s, now);
        dx_notify_tick(s);
    }
    return 0;
}

/* After every event: what follows from it for others. */
static int on_post(sd_event_source *source, void *server)
{
    struct dx_server *s = server;
    uint64_t now = dx_clock_ns();

    (void)source;
    for (struct dx_subscriber *sub = s->subscribers; sub; sub = sub->next)
        if (sub->phase != DX_SUBSCRIBER_CLOSED &&
            (sub->doomed || (dx_outbox_is_empty(&sub->out) && dx_subscriber_wants_batch(sub, now))))
            dx_subscriber_pump(sub);
    reap(s);
    dx_server_settle_streams(s);
    if (s->exit_due_ns && (!s->subscribers || now >= s->exit_due_ns))
        return sd_event_exit(s->event, 0);
    arm_timer(s);
    return 0;
}

/* ---- start and end
 * ------------------------------------------------------------------------------- */

static void begin_stop(struct dx_server *s)
{
    if (s->exit_due_ns)
        return;
    s->exit_due_ns = dx_clock_ns() + DRAIN_NS;
    if (s->mesh.io)
        sd_event_source_set_enabled(s->mesh.io, SD_EVENT_OFF);
    s->accept_again_ns = 0;
    for (struct dx_subscriber *sub = s->subscribers; sub; sub = sub->next)
        dx_subscriber_shut(sub, DX_WIRE_E_SHUTDOWN, "the service is stopping", true);
}

static int on_stop(sd_event_source *source, int fd, uint32_t revents, void *server)
{
    uint64_t n;
    ssize_t r = read(fd, &n, sizeof(n));

    (void)source;
    (void)revents;
    (void)r;
    begin_stop(server);
    return 0;
}

uint64_t dx_server_reload(struct dx_server *s)
{
    return s->options.reload && !s->exit_due_ns ? s->options.reload(s->options.ctx) : 0;
}

struct sd_event *dx_server_event(struct dx_server *s)
{
    return s->event;
}

static int on_hangup(sd_event_source *source, const struct signalfd_siginfo *si, void *server)
{
    (void)source;
    (void)si;
    if (dx_server_reload(server) == 0)
        dx_log_warning("server", "SIGHUP: there is no configuration file to read again");
    return 0;
}

static int on_signal(sd_event_source *source, const struct signalfd_siginfo *si, void *server)
{
    (void)source;
    dx_log_info("server", "stopping: %s", si->ssi_signo == SIGINT ? "SIGINT" : "SIGTERM");
    begin_stop(server);
    return 0;
}

static int add_signals(struct dx_server *s)
{
    sigset_t set;
    int r;

    sigemptyset(&set);
    sigaddset(&set, SIGTERM);
    sigaddset(&set, SIGINT);
    sigaddset(&set, SIGHUP);
    r = pthread_sigmask(SIG_BLOCK, &set, NULL);
    if (r)
        return -r;
    r = sd_event_add_signal(s->event, NULL, SIGTERM, on_signal, s);
    if (r >= 0)
        r = sd_event_add_signal(s->event, NULL, SIGINT, on_signal, s);
    return r < 0 ? r : sd_event_add_signal(s->event, NULL, SIGHUP, on_hangup, s);
}

static int add_sources(struct dx_server *s)
{
    int r = sd_event_add_io(s->event, NULL, s->stop_fd, EPOLLIN, on_stop, s);

    if (r >= 0 && s->mesh.fd >= 0)
        r = sd_event_add_io(s->event, &s->mesh.io, s->mesh.fd, EPOLLIN, on_accept, s);
    if (r >= 0)
        r = sd_event_add_time(s->event, &s->timer, CLOCK_MONOTONIC, 0, 1000, on_timer, s);
    if (r >= 0)
        r = sd_event_add_post(s->event, &s->post, on_post, s);
    if (r >= 0 && s->options.signals)
        r = add_signals(s);
    return r < 0 ? r : 0;
}

static int open_all(struct dx_server *s, struct dx_err *err)
{
    int r = sd_event_new(&s->event);

    s->stop_fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    if (r < 0 || s->stop_fd < 0)
        return dx_err_set(err, r < 0 ? r : -errno, "event loop: %s", strerror(r < 0 ? -r : errno));
    r = dx_listener_open(&s->mesh, s->options.mesh_path, "mesh", err);
    if (r < 0)
        return r;
    r = dx_control_new(&s->control, s, s->options.control_path, err);
    if (r == 0 && s->options.metrics_file && *s->options.metrics_file)
        r = dx_metrics_file_new(&s->metrics, s->options.metrics_file, s->options.metrics_s, err);
    if (r < 0)
        return r;
    r = add_sources(s);
    if (r == 0)
        r = dx_presence_new(&s->presence);
    if (r == 0)
        r = dx_watchdog_new(&s->watchdog, s);
    return r < 0 ? dx_err_set(err, r, "event loop: %s", strerror(-r)) : 0;
}

int dx_server_new(struct dx_server **out, const struct dx_server_options *options,
                  struct dx_err *err)
{
    struct dx_server *s = calloc(1, sizeof(*s));
    int r;

    if (!s)
        return dx_err_set(err, -ENOMEM, "no memory");
    s->mesh.fd = s->mesh.lock_fd = s->stop_fd = -1;
    s->options = *options;
    dx_server_set_limits(s, &options->limits);
    if (!s->options.hello_ns)
        s->options.hello_ns = HELLO_NS;
    if (!s->options.stall_ns)
        s->options.stall_ns = STALL_NS;
    s->started_ns = dx_clock_ns();
    s->tick_due_ns = s->started_ns + TICK_NS;
    r = open_all(s, err);
    if (r < 0) {
        dx_server_free(s);
        return r;
    }
    *out = s;
    return 0;
}

void dx_server_inherits(const struct dx_server *s, bool *mesh, bool *control)
{
    *mesh = dx_listener_is_inherited(&s->mesh);
    *control = dx_control_is_inherited(s->control);
}

void dx_server_paths(const struct dx_server *s, char mesh[DX_SERVER_PATH],
                     char control[DX_SERVER_PATH])
{
    dx_listener_tell(&s->mesh, mesh);
    dx_control_path(s->control, control);
}

void dx_server_free(struct dx_server *s)
{
    if (!s)
        return;
    while (s->subscribers) {
        struct dx_subscriber *next = s->subscribers->next;

        dx_subscriber_free(s->subscribers);
        s->subscribers = next;
    }
    dx_server_free_streams(s);
    dx_watchdog_free(s->watchdog);
    dx_metrics_file_free(s->metrics);
    dx_presence_free(s->presence);
    dx_control_free(s->control);
    dx_listener_close(&s->mesh);
    sd_event_source_disable_unref(s->timer);
    sd_event_source_disable_unref(s->post);
    sd_event_unref(s->event);
    if (s->stop_fd >= 0)
        close(s->stop_fd);
    free(s);
}

int dx_server_run(struct dx_server *s)
{
    dx_presence_start(s->presence, s->event);
    return sd_event_loop(s->event);
}

void dx_server_stop(struct dx_server *s)
{
    uint64_t one = 1;
    ssize_t r = write(s->stop_fd, &one, sizeof(one));

    (void)r;
}
