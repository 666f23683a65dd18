/*
 * The program around a simulated USB device (redir.h): two Unix sockets, one for QEMU's usb-redir
 * and one for orders; the loop between them. Orders of every device:
 *   plug           into the port where it was before; plug-other: into the other
 *   unplug
 *   unplug-after N when N more bytes have gone out; before a plug: N bytes after it
 *   where          answers the port, 1 or 2, or 0: it is in none
 */
#include "tests/hil/redir_priv.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

static struct {
    const struct redir_device *device;
    int fd;
    char line[128];
    size_t line_len;
} orders;

static int listen_at(const char *path)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    int fd;

    if (strlen(path) >= sizeof(address.sun_path))
        return -1;
    memcpy(address.sun_path, path, strlen(path) + 1);
    unlink(path);
    fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (fd >= 0 && bind(fd, (struct sockaddr *)&address, sizeof(address)) == 0 &&
        listen(fd, REDIR_N_PORTS) == 0)
        return fd;
    if (fd >= 0)
        close(fd);
    return -1;
}

static void obey(const char *line)
{
    char text[128] = "ok";
    unsigned long long n;

    fprintf(stderr, "redir: order '%s'\n", line);
    if (strcmp(line, "plug") == 0)
        redir_plug(false);
    else if (strcmp(line, "plug-other") == 0)
        redir_plug(true);
    else if (strcmp(line, "unplug") == 0)
        redir_unplug();
    else if (strcmp(line, "where") == 0)
        snprintf(text, sizeof(text), "%u", redir_where());
    else if (sscanf(line, "unplug-after %llu", &n) == 1)
        redir_unplug_after(n);
    else
        orders.device->order(line, text, sizeof(text));
    if (dprintf(orders.fd, "%s\n", text) < 0)
        perror("redir: answer");
}

static void read_orders(void)
{
    char bytes[128];
    ssize_t n = read(orders.fd, bytes, sizeof(bytes));

    if (n <= 0) {
        close(orders.fd);
        orders.fd = -1;
        return;
    }
    for (ssize_t i = 0; i < n; i++) {
        if (bytes[i] == '\n' && orders.line_len) {
            orders.line[orders.line_len] = 0;
            obey(orders.line);
            orders.line_len = 0;
        } else if (bytes[i] >= ' ' && orders.line_len + 1 < sizeof(orders.line)) {
            orders.line[orders.line_len++] = bytes[i];
        }
    }
}

/* Until QEMU hangs up. */
static void serve(const int fd[REDIR_N_PORTS])
{
    for (;;) {
        int wait_ms = redir_where() ? orders.device->pump() : -1;
        struct pollfd p[REDIR_N_PORTS + 1];

        for (unsigned k = 0; k < REDIR_N_PORTS; k++)
            p[k] = (struct pollfd){.fd = fd[k], .events = redir_events(k)};
        p[REDIR_N_PORTS] = (struct pollfd){.fd = orders.fd, .events = POLLIN};
        if (poll(p, REDIR_N_PORTS + 1, wait_ms) < 0 && errno != EINTR)
            return;
        if (p[REDIR_N_PORTS].revents)
            read_orders();
        for (unsigned k = 0; k < REDIR_N_PORTS; k++)
            if (redir_dispatch(k, p[k].revents) < 0)
                return;
    }
}

int redir_serve(const struct redir_device *device, const char *path, const char *orders_path)
{
    int listener = listen_at(path), orders_listener = listen_at(orders_path), fd[REDIR_N_PORTS];

    if (listener < 0 || orders_listener < 0) {
        perror(path);
        return 1;
    }
    if (dprintf(3, "ready\n") > 0)
        close(3);
    for (unsigned k = 0; k < REDIR_N_PORTS; k++) {
        fd[k] = accept4(listener, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
        if (fd[k] < 0) {
            perror("redir: accept");
            return 1;
        }
    }
    orders.fd = accept4(orders_listener, NULL, NULL, SOCK_CLOEXEC);
    orders.device = device;
    if (orders.fd < 0 || redir_begin(device, fd) < 0) {
        perror("redir: accept");
        return 1;
    }
    serve(fd);
    redir_end();
    return 0;
}
