/* A scanner on the network: TCP, port 10940. */
#include "drivers/hokuyo/scip_link.h"

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
#define CONNECT_MS 2000
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

/* A connected socket, or -errno. */
static int connect_to(const struct addrinfo *a)
{
    int fd = socket(a->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0), error = 0;
    struct pollfd p = {.fd = fd, .events = POLLOUT};
    socklen_t len = sizeof(error);

    if (fd < 0)
        return -errno;
    if (connect(fd, a->ai_addr, a->ai_addrlen) < 0)
        error = errno;
    if (error == EINPROGRESS) {
        if (poll(&p, 1, CONNECT_MS) == 1)
            getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &len);
        else
            error = ETIMEDOUT;
    }
    if (error) {
        close(fd);
        return -error;
    }
    set_up(fd);
    return fd;
}

int dx_scip_link_open_tcp(struct dx_scip_link **out, const char *address, struct dx_err *err)
{
    const struct addrinfo hints = {.ai_family = AF_UNSPEC, .ai_socktype = SOCK_STREAM};
    struct addrinfo *list = NULL;
    char text[300], place[128];
    const char *host, *port;
    int r, fd = -EHOSTUNREACH;

    if (snprintf(text, sizeof(text), "%s", address) >= (int)sizeof(text))
        return dx_err_set(err, -EINVAL, "tcp: an address of more than %zu bytes", sizeof(text) - 1);
    if (!dx_scip_tcp_split(text, &host, &port))
        return dx_err_set(err, -EINVAL, "tcp: found '%s', expected HOST or HOST:PORT", address);
    snprintf(place, sizeof(place), "%.100s:%.20s", host, port);
    r = getaddrinfo(host, port, &hints, &list);
    if (r)
        return dx_err_set(err, -EHOSTUNREACH, "%s: %s", place, gai_strerror(r));
    for (const struct addrinfo *a = list; a && fd < 0; a = a->ai_next)
        fd = connect_to(a);
    freeaddrinfo(list);
    if (fd < 0) /* not GONE: nothing would tell that it has come */
        return dx_err_set(err, fd, "%s: %s", place, strerror(-fd));
    return dx_scip_link_new_fd(out, fd, place, err);
}
