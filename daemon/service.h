/* The service: the streams of a configuration and the loop that serves them. The main thread's. */
#ifndef DX_SERVICE_H
#define DX_SERVICE_H

#include "daemon/config.h"

#define DX_SERVICE_E_LEFT                                                                          \
    1 /* it has ended, but a thread still uses what it has: end the process at once */

/*
 * Opens sources and sockets, starts the threads, serves until SIGTERM or SIGINT, and takes
 * everything down again. A signal ends it while sources are being opened, too. `config` is what is
 * in force: a reload of `file` (NULL: there is none) changes it. `ready_fd` (or -1) gets a line,
 * and the service manager READY=1, when the sockets listen. Errors, with text: what cannot be
 * opened, what is in use, -ENOMEM. DX_SERVICE_E_LEFT: `config` must stay.
 */
int dx_service_run(struct dx_config *config, const char *file, int ready_fd, struct dx_err *err);

#endif
