/* Links over a file descriptor. */
#include "drivers/hokuyo/scip_fd.h"

#include "drivers/monotonic.h"

#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#define WRITE_NS 200000000u /* for all of a command */

static struct dx_scip_fd *of(struct dx_scip_link *link)
{
    return (struct dx_scip_fd *)link;
}

/* What a failed read or write of a scanner means: most often that it is not there any more. */
static int lost(const struct dx_scip_fd *l, int error, struct dx_err *err)
{
    int result = error == 0 || error == EIO || error == ENXIO || error == ENODEV ||
                         error == ECONNRESET || error == EPIPE || error == ETIMEDOUT ||
                         error == EHOSTUNREACH || error == ENETUNREACH || error == ECONNABORTED
                     ? DX_DRIVER_E_GONE
                     : -error;

    return dx_err_set(err, result, "%s: %s", l->link.place,
                      error ? strerror(error) : "the connection was closed");
}

int dx_scip_fd_write(struct dx_scip_link *link, const uint8_t *bytes, size_t len,
                     struct dx_err *err)
{
    uint64_t due_ns = dx_clock_ns() + WRITE_NS;
    struct dx_scip_fd *l = of(link);

    while (len > 0) {
        struct pollfd p = {.fd = l->fd, .events = POLLOUT};
        ssize_t n = write(l->fd, bytes, len);
        uint64_t now = dx_clock_ns();

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

int dx_scip_fd_wait(struct dx_scip_fd *l, short events, int timeout_ms, struct dx_err *err)
{
    struct pollfd p[2] = {{.fd = l->fd, .events = events}, {.fd = l->wake_fd, .events = POLLIN}};
    uint64_t count;

    if (poll(p, 2, timeout_ms) < 0 && errno != EINTR)
        return dx_err_set(err, -errno, "%s: poll: %s", l->link.place, strerror(errno));
    if (p[1].revents) { /* what else there is stays for the next call */
        (void)!read(l->wake_fd, &count, sizeof(count));
        return DX_DRIVER_E_AGAIN;
    }
    return p[0].revents ? 0 : DX_DRIVER_E_AGAIN;
}

int dx_scip_fd_read(struct dx_scip_link *link, uint8_t *bytes, size_t cap, size_t *len,
                    int timeout_ms, struct dx_err *err)
{
    struct dx_scip_fd *l = of(link);
    int r = dx_scip_fd_wait(l, POLLIN, timeout_ms, err);
    ssize_t n;

    if (r)
        return r;
    n = read(l->fd, bytes, cap);
    if (n < 0 && (errno == EAGAIN || errno == EINTR))
        return DX_DRIVER_E_AGAIN;
    if (n <= 0)
        return lost(l, n < 0 ? errno : 0, err);
    *len = (size_t)n;
    return 0;
}

void dx_scip_fd_wake(struct dx_scip_link *link)
{
    uint64_t one = 1;

    (void)!write(of(link)->wake_fd, &one, sizeof(one));
}

int dx_scip_fd_init(struct dx_scip_fd *l, const struct dx_scip_link_ops *ops, const char *place,
                    struct dx_err *err)
{
    *l = (struct dx_scip_fd){.link = {.ops = ops}, .fd = -1};
    snprintf(l->link.place, sizeof(l->link.place), "%s", place);
    l->wake_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    return l->wake_fd < 0 ? dx_err_set(err, -errno, "%s: %s", place, strerror(errno)) : 0;
}

void dx_scip_fd_fini(struct dx_scip_fd *l)
{
    if (l->fd >= 0)
        close(l->fd);
    if (l->wake_fd >= 0)
        close(l->wake_fd);
}

static void fd_close(struct dx_scip_link *link)
{
    dx_scip_fd_fini(of(link));
    free(link);
}

int dx_scip_link_new_fd(struct dx_scip_link **out, int fd, const char *place, struct dx_err *err)
{
    static const struct dx_scip_link_ops ops = {.write = dx_scip_fd_write,
                                                .read = dx_scip_fd_read,
                                                .wake = dx_scip_fd_wake,
                                                .close = fd_close};
    struct dx_scip_fd *l = malloc(sizeof(*l));
    int r =
        l ? dx_scip_fd_init(l, &ops, place, err) : dx_err_set(err, -ENOMEM, "%s: no memory", place);

    if (r) {
        free(l);
        close(fd);
        return r;
    }
    l->fd = fd;
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
