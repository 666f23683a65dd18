/* A connection to the service without libdexel, for tests that say what they like. */
#ifndef DX_RAW_SOCKET_H
#define DX_RAW_SOCKET_H

#include <errno.h>
#include <sys/socket.h>
#include <sys/un.h>

#include "tests/system/follower.h"

static inline int connect_to(const char *path)
{
    struct sockaddr_un addr = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);

    snprintf(addr.sun_path, sizeof(addr.sun_path), "%s", path);
    if (fd < 0 || connect(fd, (const struct sockaddr *)&addr, sizeof(addr)) < 0)
        die("%s: %s", path, strerror(errno));
    return fd;
}

#endif
