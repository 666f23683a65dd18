/* MCAP's sink and source over a file descriptor, and the magic. */
#include "drivers/file/mcap.h"

#include <errno.h>
#include <sys/stat.h>
#include <unistd.h>

const uint8_t dx_mcap_magic[DX_MCAP_MAGIC_LEN] = {0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};

static int fd_write(void *ctx, uint64_t offset, const void *bytes, size_t len)
{
    int fd = (int)(intptr_t)ctx;
    const uint8_t *p = bytes;

    while (len > 0) {
        ssize_t n = pwrite(fd, p, len, (off_t)offset);

        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return n < 0 ? -errno : -EIO;
        p += n;
        len -= (size_t)n;
        offset += (uint64_t)n;
    }
    return 0;
}

static int fd_truncate(void *ctx, uint64_t len)
{
    int rc;

    do
        rc = ftruncate((int)(intptr_t)ctx, (off_t)len);
    while (rc != 0 && errno == EINTR);
    return rc == 0 ? 0 : -errno;
}

struct dx_mcap_sink dx_mcap_sink_fd(int fd)
{
    return (struct dx_mcap_sink){(void *)(intptr_t)fd, fd_write, fd_truncate};
}

static int fd_read(void *ctx, uint64_t offset, void *bytes, size_t len)
{
    int fd = (int)(intptr_t)ctx;
    uint8_t *p = bytes;

    while (len > 0) {
        ssize_t n = pread(fd, p, len, (off_t)offset);

        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return n < 0 ? -errno : -EIO; /* 0: the file has become shorter since */
        p += n;
        len -= (size_t)n;
        offset += (uint64_t)n;
    }
    return 0;
}

int dx_mcap_source_fd(struct dx_mcap_source *out, int fd)
{
    struct stat st;

    if (fstat(fd, &st) != 0)
        return -errno;
    if (!S_ISREG(st.st_mode))
        return -EINVAL;
    *out = (struct dx_mcap_source){(void *)(intptr_t)fd, fd_read, (uint64_t)st.st_size};
    return 0;
}
