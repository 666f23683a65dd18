/*
 * The streams of a configuration, opened at the start of the service. That may hang for as long as
 * a disk does not answer: a thread does it, and the main thread waits for it, or for a signal that
 * ends the service. Main thread.
 */
#ifndef DX_SERVICE_OPEN_H
#define DX_SERVICE_OPEN_H

#include "daemon/service_streams.h"

/*
 * Opens all streams of `config`, which is from `file` (NULL: from none), into the empty `list`; on
 * an error the list has those that were opened before. SIGTERM and SIGINT are blocked: one that
 * comes is left pending, for the loop. Errors, with text: what cannot be opened, -ENOMEM.
 * DX_SERVICE_E_LEFT: such a signal came, and a source did not open in the second after it; that
 * thread goes on.
 */
int dx_service_open(struct dx_stream_list *list, const struct dx_config *config, const char *file,
                    struct dx_pool *pool, struct dx_err *err);

#endif
