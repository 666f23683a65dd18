/* Temporary name, fsync, rename. */
#include "tools/out_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static int open_or_errno(const char *path, int flags)
{
    int fd = open(path, flags | O_CLOEXEC, 0666);

    if (fd < 0)
        return -errno;
    return fd;
}

static int open_temp(struct dx_out_file *f)
{
    int fd;

    for (int attempt = 0; attempt < 100; attempt++) {
        if (asprintf(&f->temp, "%s.%ld-%d.tmp", f->path, (long)getpid(), attempt) < 0) {
            f->temp = NULL;
            return -ENOMEM;
        }
        fd = open_or_errno(f->temp, O_WRONLY | O_CREAT | O_EXCL);
        if (fd >= 0)
            return fd;
        free(f->temp);
        f->temp = NULL;
        if (fd != -EEXIST)
            return fd;
    }
    return -EEXIST;
}

static int open_path(struct dx_out_file *f, const char *path)
{
    struct stat st;

    if (stat(path, &st) == 0 && !S_ISREG(st.st_mode)) {
        f->path = strdup(path);
        return f->path ? open_or_errno(path, O_WRONLY) : -ENOMEM;
    }
    /* A link stays a link: what it names is replaced. */
    f->path = realpath(path, NULL);
    if (!f->path)
        f->path = strdup(path);
    return f->path ? open_temp(f) : -ENOMEM;
}

int dx_out_file_open(struct dx_out_file *f, const char *path, struct dx_err *err)
{
    int fd;

    *f = (struct dx_out_file){0};
    fd = open_path(f, path);
    if (fd >= 0) {
        f->stream = fdopen(fd, "wb");
        if (f->stream)
            return 0;
        close(fd);
        fd = -ENOMEM;
    }
    dx_out_file_abort(f);
    return dx_err_set(err, fd, "%s: cannot be opened for writing: %s", path, strerror(-fd));
}

/* errno of the first failure is gone by now when stdio met it early; flush tells it again. */
static int finish_stream(struct dx_out_file *f)
{
    int rc = 0;

    errno = 0;
    if (fflush(f->stream) != 0 || ferror(f->stream))
        rc = errno ? -errno : -EIO;
    if (rc == 0 && f->temp && fsync(fileno(f->stream)) != 0)
        rc = -errno;
    if (fclose(f->stream) != 0 && rc == 0)
        rc = -errno;
    f->stream = NULL;
    return rc;
}

int dx_out_file_commit(struct dx_out_file *f, struct dx_err *err)
{
    int rc = finish_stream(f);

    if (rc == 0 && f->temp && rename(f->temp, f->path) != 0)
        rc = -errno;
    if (rc < 0)
        dx_err_set(err, rc, "%s: cannot be written: %s", f->path, strerror(-rc));
    else {
        free(f->temp);
        f->temp = NULL;
    }
    dx_out_file_abort(f);
    return rc;
}

void dx_out_file_abort(struct dx_out_file *f)
{
    if (f->stream)
        fclose(f->stream);
    if (f->temp)
        unlink(f->temp);
    free(f->temp);
    free(f->path);
    *f = (struct dx_out_file){0};
}
