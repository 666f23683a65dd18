/* Listening sockets: inherited or made. Before the loop runs. */
#include "daemon/server_priv.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

/* The inherited socket of that name, or -1. The variables stay: each name is asked for once. */
static int inherited(const char *name)
{
    char **names = NULL;
    int n = sd_listen_fds_with_names(0, &names), fd = -1;

    for (int k = 0; k < n; k++) {
        if (fd < 0 && !strcmp(names[k], name) &&
            sd_is_socket_unix(SD_LISTEN_FDS_START + k, SOCK_STREAM, 1, NULL, 0) > 0)
            fd = SD_LISTEN_FDS_START + k;
        free(names[k]);
    }
    free(names);
    return fd;
}

/* Whether somebody answers at the address: 1, 0, or -errno. */
static int answers(const struct sockaddr_un *addr)
{
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0), r;

    if (fd < 0)
        return -errno;
    /* EAGAIN: its backlog is full, so it is alive */
    r = connect(fd, (const struct sockaddr *)addr, sizeof(*addr)) == 0 || errno == EAGAIN ? 1
        : errno == ECONNREFUSED                                                           ? 0
                                                                                          : -errno;
    close(fd);
    return r;
}

/* Removes what a service that died left behind, and nothing else. */
static int clear_stale(const struct sockaddr_un *addr, struct dx_err *err)
{
    struct stat st;
    int r;

    if (lstat(addr->sun_path, &st) < 0)
        return errno == ENOENT ? 0
                               : dx_err_set(err, -errno, "%s: %s", addr->sun_path, strerror(errno));
    if (!S_ISSOCK(st.st_mode))
        return dx_err_set(err, -EEXIST, "%s: found something that is no socket, expected none",
                          addr->sun_path);
    r = answers(addr);
    if (r > 0)
        return dx_err_set(err, -EADDRINUSE, "%s: another service answers here", addr->sun_path);
    if (r < 0)
        return dx_err_set(err, r, "%s: %s", addr->sun_path, strerror(-r));
    return unlink(addr->sun_path) < 0 && errno != ENOENT
               ? dx_err_set(err, -errno, "%s: %s", addr->sun_path, strerror(errno))
               : 0;
}

/* The mask makes the mode right from the first moment, before anyone can connect. */
static int bind_listen(int fd, const struct sockaddr_un *addr)
{
    mode_t mask = umask(0117);
    int r = bind(fd, (const struct sockaddr *)addr, sizeof(*addr)) < 0 ? -errno : 0;

    umask(mask);
    if (r == 0 && listen(fd, SOMAXCONN) < 0) {
        r = -errno;
        unlink(addr->sun_path);
    }
    return r;
}

/* Whether the open file is the one that has the name now: its last owner may have removed it
 * between our open and our lock. */
static bool is_current(int fd, const char *name)
{
    struct stat ours, named;

    return fstat(fd, &ours) == 0 && stat(name, &named) == 0 && ours.st_dev == named.st_dev &&
           ours.st_ino == named.st_ino;
}

/* Holds PATH.lock for as long as the socket is ours: two services that start at once would each
 * find the other's socket, bound and not yet listening, stale. */
static int lock(struct dx_listener *l, struct dx_err *err)
{
    for (;;) {
        int fd = open(l->lock_name, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);

        if (fd < 0)
            return dx_err_set(err, -errno, "%s, of a socket: %s", l->lock_name, strerror(errno));
        if (flock(fd, LOCK_EX | LOCK_NB) < 0) {
            int error = errno;

            close(fd);
            return error == EWOULDBLOCK
                       ? dx_err_set(err, -EADDRINUSE, "%s: another service has this socket",
                                    l->lock_name)
                       : dx_err_set(err, -error, "%s: %s", l->lock_name, strerror(error));
        }
        if (is_current(fd, l->lock_name)) {
            l->lock_fd = fd;
            return 0;
        }
        close(fd);
    }
}

/* Which file the socket is, so that only that one is removed. */
static void remember(struct dx_listener *l)
{
    struct stat st;

    if (lstat(l->made, &st) == 0) {
        l->dev = st.st_dev;
        l->ino = st.st_ino;
    }
}

static int make(struct dx_listener *l, const char *path, struct dx_err *err)
{
    struct sockaddr_un addr = {.sun_family = AF_UNIX};
    int r;

    if (strlen(path) >= sizeof(addr.sun_path))
        return dx_err_set(err, -ENAMETOOLONG, "%s: a socket path has at most %zu bytes", path,
                          sizeof(addr.sun_path) - 1);
    memcpy(addr.sun_path, path, strlen(path));
    if (asprintf(&l->lock_name, "%s.lock", path) < 0) {
        l->lock_name = NULL;
        return dx_err_set(err, -ENOMEM, "%s: no memory", path);
    }
    r = lock(l, err);
    if (r == 0)
        r = clear_stale(&addr, err);
    if (r < 0)
        return r;
    l->made = strdup(path);
    l->fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    r = !l->made ? -ENOMEM : l->fd < 0 ? -errno : bind_listen(l->fd, &addr);
    if (r < 0) {
        free(l->made); /* not ours to unlink */
        l->made = NULL;
        return dx_err_set(err, r, "%s: %s", path, strerror(-r));
    }
    remember(l);
    return 0;
}

int dx_listener_open(struct dx_listener *l, const char *path, const char *name, struct dx_err *err)
{
    l->fd = inherited(name);
    l->lock_fd = -1;
    l->made = l->lock_name = NULL;
    if (l->fd < 0)
        return path ? make(l, path, err) : 0;
    if (fcntl(l->fd, F_SETFL, fcntl(l->fd, F_GETFL) | O_NONBLOCK) < 0)
        return dx_err_set(err, -errno, "inherited socket '%s': %s", name, strerror(errno));
    return 0;
}

void dx_listener_tell(const struct dx_listener *l, char path[DX_SERVER_PATH])
{
    struct sockaddr_un addr = {0};
    socklen_t len = sizeof(addr) - 1; /* a 0 stays behind the longest */
    const char *at = addr.sun_path;

    snprintf(path, DX_SERVER_PATH, "none");
    if (l->fd < 0 || getsockname(l->fd, (struct sockaddr *)&addr, &len) < 0)
        return;
    if (*at)
        snprintf(path, DX_SERVER_PATH, "%s", at);
    else
        snprintf(path, DX_SERVER_PATH, "@%s", at + 1); /* a name that is in no file system */
}

void dx_listener_close(struct dx_listener *l)
{
    struct stat st;

    l->io = sd_event_source_disable_unref(l->io);
    if (l->fd >= 0)
        close(l->fd);
    if (l->made && lstat(l->made, &st) == 0 && st.st_dev == l->dev && st.st_ino == l->ino)
        unlink(l->made);
    if (l->lock_fd >= 0) {
        unlink(l->lock_name); /* before it is let go of: is_current() */
        close(l->lock_fd);
    }
    free(l->lock_name);
    l->lock_name = NULL;
    free(l->made);
    l->made = NULL;
    l->fd = l->lock_fd = -1;
}
