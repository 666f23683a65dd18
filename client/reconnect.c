/* Trying again: one turn of a dispatch, with or without a connection. One thread at a time. */
#include "client/reconnect.h"

#include "client/session.h"

#include <errno.h>
#include <sys/epoll.h>
#include <sys/timerfd.h>
#include <unistd.h>

#define FIRST_NS   100000000u
#define LONGEST_NS 2000000000u

void dx_reconnect_init(struct dx_reconnect *r)
{
    *r = (struct dx_reconnect){.poll_fd = -1, .timer_fd = -1};
}

void dx_reconnect_fini(struct dx_reconnect *r)
{
    if (r->poll_fd >= 0)
        close(r->poll_fd);
    if (r->timer_fd >= 0)
        close(r->timer_fd);
}

static void arm(struct dx_reconnect *r)
{
    uint64_t ns = r->n_tries ? FIRST_NS : 1; /* 0 would disarm it */
    struct itimerspec at = {0};

    for (uint32_t k = 1; k < r->n_tries && ns < LONGEST_NS; k++)
        ns *= 2;
    ns = ns < LONGEST_NS ? ns : LONGEST_NS;
    at.it_value.tv_sec = (time_t)(ns / 1000000000u);
    at.it_value.tv_nsec = (long)(ns % 1000000000u);
    timerfd_settime(r->timer_fd, 0, &at, NULL);
    r->n_tries++;
}

int dx_reconnect_start(struct dexel *d, const char *path)
{
    struct dx_reconnect *r = &d->again;
    struct epoll_event e = {.events = EPOLLIN};

    if (strlen(path) >= sizeof(r->path))
        return dx_err_set(&d->err, -ENAMETOOLONG, "%s: a socket path has at most %zu bytes", path,
                          sizeof(r->path) - 1);
    memcpy(r->path, path, strlen(path) + 1);
    r->poll_fd = epoll_create1(EPOLL_CLOEXEC);
    r->timer_fd = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC);
    if (r->poll_fd < 0 || r->timer_fd < 0 ||
        epoll_ctl(r->poll_fd, EPOLL_CTL_ADD, r->timer_fd, &e) < 0)
        return dx_err_set(&d->err, -errno, "waiting for a service: %s", strerror(errno));
    arm(r);
    return 0;
}

/* A socket that is in the epoll instance, with what we say first on its way. */
static int connect_again(struct dexel *d)
{
    struct epoll_event e = {.events = EPOLLIN};
    int r = dx_connection_open(&d->connection, d->again.path, DX_CONNECTION_TRY, &d->err);

    if (r < 0)
        return r;
    if (epoll_ctl(d->again.poll_fd, EPOLL_CTL_ADD, d->connection.fd, &e) < 0)
        return dx_err_set(&d->err, -errno, "waiting for a service: %s", strerror(errno));
    r = dx_session_hello(d);
    for (uint32_t k = 0; r == 0 && k < d->n_asked; k++)
        r = dx_connection_send(&d->connection, DX_MSG_NEXT, NULL, 0);
    return r < 0 ? dx_err_set(&d->err, r, "%s: %s", d->again.path, strerror(-r)) : 0;
}

/* There is no connection, and why stands in d->err: told once. A callback's value. */
static int lose(struct dexel *d)
{
    int r = dx_session_restart(d);

    if (r < 0)
        return dx_session_fail(d, dx_err_set(&d->err, r, "%s", strerror(-r)));
    arm(&d->again);
    if (d->again.is_told)
        return 0;
    d->again.is_told = true;
    return d->callbacks.state ? d->callbacks.state(d->user, DEXEL_GONE, d->err.text) : 0;
}

int dx_reconnect_dispatch(struct dexel *d)
{
    uint64_t n;
    int r;

    if (d->connection.fd < 0) {
        if (read(d->again.timer_fd, &n, sizeof(n)) < 0)
            return 0; /* not yet */
        if (connect_again(d) < 0)
            return lose(d);
    }
    r = dx_session_turn(d);
    if (d->failed != -ECONNRESET)
        return r;
    d->again.is_lost = d->again.is_lost || d->stream != DX_WIRE_NO_STREAM;
    return lose(d);
}

int dx_reconnect_welcomed(struct dexel *d)
{
    const bool was_lost = d->again.is_lost;

    d->again.is_lost = false;
    return was_lost && d->callbacks.reset ? d->callbacks.reset(d->user, "a new connection") : 0;
}

void dx_reconnect_served(struct dexel *d)
{
    d->again.n_tries = 0;
    d->again.is_told = false;
}
