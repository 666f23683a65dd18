/* An MCAP file by its name. Owned by one thread. */
#ifndef DX_MCAP_OPEN_H
#define DX_MCAP_OPEN_H

#include "drivers/file/mcap_read.h"

struct dx_mcap_file {
    int fd;
    struct dx_mcap_reader *reader;
};

/* `options` may be NULL. Errors: -errno, err names the path. */
int dx_mcap_file_open(struct dx_mcap_file *f, const char *path,
                      const struct dx_mcap_read_options *options, struct dx_err *err);
void dx_mcap_file_close(struct dx_mcap_file *f);

#endif
