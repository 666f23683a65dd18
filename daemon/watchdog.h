/*
 * The watchdog of the service manager (WatchdogSec), fed by the loop while every thread that is
 * watched gives signs of life (heartbeat.h): a thread of a stream that hangs is told in the log,
 * and the manager starts the service anew. A recorder that waits for its disk is told, too, but is
 * no reason: a new service would find the same disk. Loop thread.
 */
#ifndef DX_WATCHDOG_H
#define DX_WATCHDOG_H

#include <stdbool.h>
#include <stdint.h>

#include "daemon/heartbeat.h"

struct dx_server;
struct dx_watchdog;

/* Once the server has its event loop. Without a manager that watches, hung threads are told all the
 * same. Errors: -ENOMEM, -errno. */
int dx_watchdog_new(struct dx_watchdog **out, struct dx_server *server);
void dx_watchdog_free(struct dx_watchdog *w);

/* What a watched thread is called: "mesher". */
const char *dx_watchdog_thread(enum dx_beating thread);

/* Looks at all streams, and tells what has changed; false: one of them has a thread that hangs. */
bool dx_watchdog_look(struct dx_watchdog *w, uint64_t now_ns);

#endif
