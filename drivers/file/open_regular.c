/* Opening regular files, and those alone. */
#include "drivers/file/open_regular.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* The type is asked of what is open: the name may mean something else by then. */
int dx_open_regular(const char *path, struct dx_err *err)
{
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK);
    struct stat st;
    int rc = 0;

    if (fd < 0)
        rc = errno == ENXIO ? -EINVAL : -errno; /* a socket, or a node without its device */
    else if (fstat(fd, &st) != 0)
        rc = -errno;
    else if (!S_ISREG(st.st_mode))
        rc = -EINVAL;
    if (rc == 0)
        return fd;
    if (fd >= 0)
        close(fd);
    return dx_err_set(err, rc, "%s: %s", path,
                      rc == -EINVAL ? "not a regular file" : strerror(-rc));
}
