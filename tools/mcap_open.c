/* An MCAP file by its name. */
#include "tools/mcap_open.h"

#include "drivers/file/open_regular.h"

#include <string.h>
#include <unistd.h>

int dx_mcap_file_open(struct dx_mcap_file *f, const char *path,
                      const struct dx_mcap_read_options *options, struct dx_err *err)
{
    struct dx_mcap_source source;
    int rc;

    f->fd = dx_open_regular(path, err);
    if (f->fd < 0)
        return f->fd;
    rc = dx_mcap_source_fd(&source, f->fd);
    if (rc) {
        dx_err_set(err, rc, "%s: %s", path, strerror(-rc));
    } else {
        rc = dx_mcap_reader_open(&f->reader, &source, options, err);
        if (rc)
            dx_err_prefix(err, path);
    }
    if (rc)
        close(f->fd);
    return rc;
}

void dx_mcap_file_close(struct dx_mcap_file *f)
{
    dx_mcap_reader_free(f->reader);
    close(f->fd);
}
