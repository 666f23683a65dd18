/* Connect, ask, read a line. */
#include "tools/control_client.h"

#include "core/wire/wire.h"

#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#define MAX_REPLY  (16u << 20)
#define TIMEOUT_MS 5000

static int too_long(struct dx_err *err, const char *path)
{
    return dx_err_set(err, -ENAMETOOLONG,
                      "%s: found a socket path of %zu bytes, expected at most 107", path,
                      strlen(path));
}

int dx_control_path(char out[108], const char *given, struct dx_err *err)
{
    const char *path = given ? given : getenv("DEXELD_CONTROL");
    char beside[128];

    if (!path || !*path)
        path = "/run/dexeld/control.sock";
    if (strlen(path) > 107)
        return too_long(err, path);
    snprintf(beside, sizeof(beside), "%s.control", path);
    if (given && access(beside, F_OK) == 0)
        path = beside;
    if (strlen(path) > 107)
        return too_long(err, path);
    strcpy(out, path);
    return 0;
}

static int connect_to(const char *path)
{
    struct sockaddr_un addr = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0), rc;

    if (fd < 0)
        return -errno;
    memcpy(addr.sun_path, path, strnlen(path, sizeof(addr.sun_path) - 1));
    if (connect(fd, (struct sockaddr *)&addr, sizeof(addr)) == 0)
        return fd;
    rc = -errno;
    close(fd);
    return rc;
}

/* Blanks make it as long as a header of the mesh protocol: a mesh socket then refuses it at once,
 * and does not wait for the rest. */
static int send_line(int fd, const char *request)
{
    char *line;
    int len = asprintf(&line, "%-*s\n", DX_WIRE_HEADER_LEN, request), sent = 0, rc = 0;

    if (len < 0)
        return -ENOMEM;
    while (sent < len && rc == 0) {
        ssize_t n = send(fd, line + sent, (size_t)(len - sent), MSG_NOSIGNAL);

        sent += n > 0 ? (int)n : 0;
        rc = n < 0 && errno != EINTR ? -errno : 0;
    }
    free(line);
    if (rc == -EPIPE || rc == -ECONNRESET)
        return 0; /* what it said before it went is still to be read */
    return rc;
}

/* Up to `room` bytes more, waiting for them. */
static ssize_t receive(int fd, char *to, size_t room, int timeout_ms)
{
    struct pollfd p = {.fd = fd, .events = POLLIN};
    ssize_t n;
    int rc;

    do {
        rc = poll(&p, 1, timeout_ms);
    } while (rc < 0 && errno == EINTR);
    if (rc == 0)
        return -ETIMEDOUT;
    n = rc < 0 ? -1 : read(fd, to, room);
    if (n < 0)
        return -errno;
    return n == 0 ? -ECONNRESET : n;
}

/* Waits for the first byte, and says so when it takes its time. */
static void await_answer(int fd, const char *late)
{
    struct pollfd p = {.fd = fd, .events = POLLIN};

    if (late && poll(&p, 1, TIMEOUT_MS) == 0)
        fprintf(stderr, "%s\n", late);
}

static int read_line(char **reply, int fd, int timeout_ms)
{
    size_t len = 0, cap = 16384;
    char *line = calloc(1, cap), *end = NULL;
    ssize_t n = line ? 0 : -ENOMEM;

    while (n >= 0 && !end) {
        if (len == cap && cap < MAX_REPLY) {
            char *more = realloc(line, 2 * cap);

            if (!more) {
                n = -ENOMEM;
                break;
            }
            line = more;
            cap *= 2;
        }
        n = len == cap ? -EMSGSIZE : receive(fd, line + len, cap - len, timeout_ms);
        if (n > 0 && line[0] != '{')
            n = -EPROTO;
        if (n > 0) {
            end = memchr(line + len, '\n', (size_t)n);
            len += (size_t)n;
        }
    }
    if (n < 0) {
        free(line);
        return (int)n;
    }
    *end = '\0';
    *reply = line;
    return 0;
}

static int tell(struct dx_err *err, const char *path, int rc)
{
    switch (rc) {
    case -ECONNREFUSED:
    case -ENOENT:
        return dx_err_set(err, rc, "%s: no dexeld answers here", path);
    case -EPROTO:
        return dx_err_set(
            err, rc,
            "%s: found no JSON line in answer, expected one; this seems to be the mesh "
            "socket, but this needs the control socket (control_socket in the "
            "configuration)",
            path);
    case -ECONNRESET:
    case -EPIPE:
        return dx_err_set(err, rc, "%s: dexeld has gone before it answered", path);
    case -ETIMEDOUT:
        return dx_err_set(err, rc, "%s: dexeld is there, and does not answer", path);
    case -EACCES:
        return dx_err_set(err, rc, "%s: %s (dexel doctor tells of groups)", path, strerror(-rc));
    default:
        return dx_err_set(err, rc, "%s: %s", path, strerror(-rc));
    }
}

int dx_control_ask_within(char **reply, const char *path, const char *request, int timeout_ms,
                          const char *late, struct dx_err *err)
{
    int fd = connect_to(path), rc = fd;

    if (fd >= 0) {
        rc = send_line(fd, request);
        if (rc == 0) {
            await_answer(fd, late);
            rc = read_line(reply, fd, timeout_ms);
        }
        close(fd);
    }
    return rc < 0 ? tell(err, path, rc) : 0;
}

int dx_control_ask(char **reply, const char *path, const char *request, struct dx_err *err)
{
    return dx_control_ask_within(reply, path, request, TIMEOUT_MS, NULL, err);
}

int dx_control_take(json_t **reply, const char *line, const char *path, struct dx_err *err)
{
    json_t *o = json_loads(line, 0, NULL);
    const char *refused = json_string_value(json_object_get(o, "error"));
    int rc = 0;

    if (!json_is_object(o))
        rc = dx_err_set(err, -EBADMSG, "%s: found '%.40s', expected a JSON object", path, line);
    else if (refused)
        rc = dx_err_set(err, -EBADMSG, "%s: the service: %s", path, refused);
    if (rc < 0)
        json_decref(o);
    *reply = rc < 0 ? NULL : o;
    return rc;
}
