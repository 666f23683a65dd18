/*
 * A scanner on the network: TCP, port 10940. Connecting is begun at the opening and waited for by
 * connect(), so that it can be woken; a name is asked for at the opening, which cannot.
 */
#include "drivers/hokuyo/scip_fd.h"

#include "drivers/monotonic.h"

#include <errno.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#define PORT       "10940"
#define CONNECT_NS UINT64_C(2000000000) /* for each of its addresses */
#define DEAD_MS    5000 /* unanswered bytes, or probes, for so long: the scanner is gone */

/* Digits of a port, 1 to 65535. */
static bool is_port(const char *text)
{
    size_t len = strspn(text, "0123456789");
    unsigned long n = len && len <= 5 && !text[len] ? strtoul(text, NULL, 10) : 0;

    return n >= 1 && n <= 65535;
}

bool dx_scip_tcp_split(char *text, const char **host, const char **port)
{
    char *colon = strrchr(text, ':'), *bracket = strrchr(text, ']');

    *host = text;
    *port = PORT;
    if (text[0] == '[') {
        *host = text + 1;
        if (!bracket || (bracket[1] && bracket[1] != ':'))
            return false;
        if (bracket[1])
            *port = bracket + 2;
        *bracket = 0;
    } else if (colon && strchr(text, ':') == colon) {
        *colon = 0;
        *port = colon + 1;
    }
    return **host && is_port(*port);
}

static void set_up(int fd)
{
    const int one = 1, idle_s = 2, between_s = 1, n = 3, dead_ms = DEAD_MS;

    /* each may fail without harm: the session's own watchdog is there */
    setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &one, sizeof(one));
    setsockopt(fd, SOL_SOCKET, SO_KEEPALIVE, &one, sizeof(one));
    setsockopt(fd, IPPROTO_TCP, TCP_KEEPIDLE, &idle_s, sizeof(idle_s));
    setsockopt(fd, IPPROTO_TCP, TCP_KEEPINTVL, &between_s, sizeof(between_s));
    setsockopt(fd, IPPROTO_TCP, TCP_KEEPCNT, &n, sizeof(n));
    setsockopt(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, &dead_ms, sizeof(dead_ms));
}

struct tcp_link {
    struct dx_scip_fd fd;         /* its fd -1: between two addresses */
    struct addrinfo *list, *next; /* list NULL: it is connected */
    uint64_t due_ns;              /* for the address that is tried */
    int code;                     /* why the last one failed */
};

static void give_up(struct tcp_link *l, int code)
{
    close(l->fd.fd);
    l->fd.fd = -1;
    l->code = code;
}

/* The next address that takes a connection, or may: l->fd.fd is -1 when there is none. */
static void begin(struct tcp_link *l)
{
    while (l->next && l->fd.fd < 0) {
        const struct addrinfo *a = l->next;

        l->next = a->ai_next;
        l->fd.fd = socket(a->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
        l->due_ns = dx_clock_ns() + CONNECT_NS;
        if (l->fd.fd < 0)
            l->code = -errno;
        else if (connect(l->fd.fd, a->ai_addr, a->ai_addrlen) < 0 && errno != EINPROGRESS)
            give_up(l, -errno);
    }
}

/* The kernel has an answer. */
static void finish(struct tcp_link *l)
{
    int error = 0;
    socklen_t len = sizeof(error);

    if (getsockopt(l->fd.fd, SOL_SOCKET, SO_ERROR, &error, &len) < 0)
        error = errno;
    if (error) {
        give_up(l, -error);
        return;
    }
    set_up(l->fd.fd);
    freeaddrinfo(l->list);
    l->list = l->next = NULL;
}

static int tcp_connect(struct dx_scip_link *link, int timeout_ms, struct dx_err *err)
{
    struct tcp_link *l = (struct tcp_link *)link;
    uint64_t now = dx_clock_ns();
    int r;

    if (!l->list)
        return 0;
    begin(l);
    if (l->fd.fd < 0) /* not GONE: nothing would tell that it has come */
        return dx_err_set(err, l->code, "%s: %s", link->place, strerror(-l->code));
    r = dx_scip_fd_wait(&l->fd, POLLOUT, timeout_ms, err);
    if (r == 0)
        finish(l);
    else if (r == DX_DRIVER_E_AGAIN && now >= l->due_ns)
        give_up(l, -ETIMEDOUT);
    return l->list && r >= 0 ? DX_DRIVER_E_AGAIN : r;
}

static void tcp_close(struct dx_scip_link *link)
{
    struct tcp_link *l = (struct tcp_link *)link;

    if (l->list)
        freeaddrinfo(l->list);
    dx_scip_fd_fini(&l->fd);
    free(l);
}

int dx_scip_link_open_tcp(struct dx_scip_link **out, const char *address, struct dx_err *err)
{
    static const struct dx_scip_link_ops ops = {.connect = tcp_connect,
                                                .write = dx_scip_fd_write,
                                                .read = dx_scip_fd_read,
                                                .wake = dx_scip_fd_wake,
                                                .close = tcp_close};
    const struct addrinfo hints = {.ai_family = AF_UNSPEC, .ai_socktype = SOCK_STREAM};
    char text[300], place[128];
    const char *host, *port;
    struct tcp_link *l;
    int r;

    if (snprintf(text, sizeof(text), "%s", address) >= (int)sizeof(text))
        return dx_err_set(err, -EINVAL, "tcp: an address of more than %zu bytes", sizeof(text) - 1);
    if (!dx_scip_tcp_split(text, &host, &port))
        return dx_err_set(err, -EINVAL, "tcp: found '%s', expected HOST or HOST:PORT", address);
    snprintf(place, sizeof(place), "%.100s:%.20s", host, port);
    l = calloc(1, sizeof(*l));
    if (!l)
        return dx_err_set(err, -ENOMEM, "%s: no memory", place);
    r = dx_scip_fd_init(&l->fd, &ops, place, err);
    if (r) {
        free(l);
        return r;
    }
    r = getaddrinfo(host, port, &hints, &l->list);
    if (r) {
        l->list = NULL;
        tcp_close(&l->fd.link);
        return dx_err_set(err, -EHOSTUNREACH, "%s: %s", place, gai_strerror(r));
    }
    l->next = l->list;
    l->code = -EHOSTUNREACH;
    *out = &l->fd.link;
    return 0;
}
