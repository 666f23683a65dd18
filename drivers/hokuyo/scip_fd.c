/* Links over a file descriptor: what a tty and a TCP connection have in common. */
#include "drivers/hokuyo/scip_link.h"

#include "drivers/replay.h"

#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#define WRITE_NS 200000000u /* for all of a command */

struct fd_link {
    struct dx_scip_link link;
    int fd, wake_fd;
};

static struct fd_link *of(struct dx_scip_link *link)
{
    return (struct fd_link *)link;
}

/* What a failed read or write of a scanner means: most often that it is not there any more. */
static int lost(const struct fd_link *l, int error, struct dx_err *err)
{
    int result = error == 0 || error == EIO || error == ENXIO || error == ENODEV ||
                         error == ECONNRESET || error == EPIPE || error == ETIMEDOUT ||
                         error == EHOSTUNREACH || error == ENETUNREACH || error == ECONNABORTED
                     ? DX_DRIVER_E_GONE
                     : -error;

    return dx_err_set(err, result, "%s: %s", l->link.place,
                      error ? strerror(error) : "the connection was closed");
}

static int fd_write(struct dx_scip_link *link, const uint8_t *bytes, size_t len, struct dx_err *err)
{
    uint64_t due_ns = dx_pace_now() + WRITE_NS;
    struct fd_link *l = of(link);

    while (len > 0) {
        struct pollfd p = {.fd = l->fd, .events = POLLOUT};
        ssize_t n = write(l->fd, bytes, len);
        uint64_t now = dx_pace_now();

        if (n > 0) {
            bytes += n;
            len -= (size_t)n;
        } else if (n < 0 && errno != EAGAIN && errno != EINTR) {
            return lost(l, errno, err);
        } else if (now >= due_ns) {
            return dx_err_set(err, -ETIMEDOUT, "%s: takes no commands", link->place);
        } else {
            poll(&p, 1, (int)((due_ns - now) / 1000000) + 1);
        }
    }
    return 0;
}

static int fd_read(struct dx_scip_link *link, uint8_t *bytes, size_t cap, size_t *len,
                   int timeout_ms, struct dx_err *err)
{
    struct fd_link *l = of(link);
    struct pollfd p[2] = {{.fd = l->fd, .events = POLLIN}, {.fd = l->wake_fd, .events = POLLIN}};
    uint64_t count;
    ssize_t n;

    if (poll(p, 2, timeout_ms) < 0 && errno != EINTR)
        return dx_err_set(err, -errno, "%s: poll: %s", link->place, strerror(errno));
    if (p[1].revents) { /* what else there is stays for the next call */
        (void)!read(l->wake_fd, &count, sizeof(count));
        return DX_DRIVER_E_AGAIN;
    }
    if (!p[0].revents)
        return DX_DRIVER_E_AGAIN;
    n = read(l->fd, bytes, cap);
    if (n < 0 && (errno == EAGAIN || errno == EINTR))
        return DX_DRIVER_E_AGAIN;
    if (n <= 0)
        return lost(l, n < 0 ? errno : 0, err);
    *len = (size_t)n;
    return 0;
}

static void fd_wake(struct dx_scip_link *link)
{
    uint64_t one = 1;

    (void)!write(of(link)->wake_fd, &one, sizeof(one));
}

static void fd_close(struct dx_scip_link *link)
{
    close(of(link)->fd);
    close(of(link)->wake_fd);
    free(link);
}

static const struct dx_scip_link_ops fd_ops = {fd_write, fd_read, fd_wake, fd_close};

int dx_scip_link_new_fd(struct dx_scip_link **out, int fd, const char *place, struct dx_err *err)
{
    struct fd_link *l = calloc(1, sizeof(*l));
    int r;

    if (l)
        l->wake_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (!l || l->wake_fd < 0) {
        r = l ? -errno : -ENOMEM;
        free(l);
        close(fd);
        return dx_err_set(err, r, "%s: %s", place, strerror(-r));
    }
    l->link.ops = &fd_ops;
    l->fd = fd;
    snprintf(l->link.place, sizeof(l->link.place), "%s", place);
    *out = &l->link;
    return 0;
}

int dx_scip_link_open(struct dx_scip_link **out, const struct dx_hokuyo_config *c,
                      struct dx_err *err)
{
    if (c->tty && c->tty[0])
        return dx_scip_link_open_tty(out, c->tty, c->baud, err);
    if (c->tcp && c->tcp[0])
        return dx_scip_link_open_tcp(out, c->tcp, err);
    return dx_scip_link_open_usb(out, c->port, err);
}

void dx_scip_link_close(struct dx_scip_link *link)
{
    if (link)
        link->ops->close(link);
}
