/*
 * The program around a simulated USB device (redir.h): two Unix sockets, one for QEMU's usb-redir
 * and one for orders; the loop between them.
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
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);

    if (fd < 0 || strlen(path) >= sizeof(address.sun_path))
        return -1;
    memcpy(address.sun_path, path, strlen(path) + 1);
    unlink(path);
    if (bind(fd, (struct sockaddr *)&address, sizeof(address)) < 0 || listen(fd, 1) < 0)
        return -1;
    return fd;
}

static void obey(const char *line)
{
    char text[128] = "ok";

    fprintf(stderr, "redir: order '%s'\n", line);
    if (strcmp(line, "plug") == 0)
        redir_plug();
    else if (strcmp(line, "unplug") == 0)
        redir_unplug();
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
static void serve(int fd)
{
    for (;;) {
        int wait_ms = redir_is_in() ? orders.device->pump() : -1;
        struct pollfd p[2] = {
            {.fd = fd, .events = redir_events()},
            {.fd = orders.fd, .events = POLLIN},
        };

        if (poll(p, 2, wait_ms) < 0 && errno != EINTR)
            return;
        if (p[1].revents)
            read_orders();
        if (redir_dispatch(p[0].revents) < 0)
            return;
    }
}

int redir_serve(const struct redir_device *device, const char *path, const char *orders_path)
{
    int listener = listen_at(path), orders_listener = listen_at(orders_path), fd;

    if (listener < 0 || orders_listener < 0) {
        perror(path);
        return 1;
    }
    if (dprintf(3, "ready\n") > 0)
        close(3);
    fd = accept4(listener, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
    orders.fd = accept4(orders_listener, NULL, NULL, SOCK_CLOEXEC);
    orders.device = device;
    if (fd < 0 || orders.fd < 0 || redir_begin(device, fd) < 0) {
        perror("redir: accept");
        return 1;
    }
    serve(fd);
    redir_end();
    return 0;
}
