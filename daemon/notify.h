/*
 * What the service manager is told (sd_notify): that the service is ready, reads its configuration
 * again, ends; and what it does in a line, which `systemctl status` shows:
 *
 *   4 streams, 3 live, kin: gone; 7 clients
 *
 * and, while that is so, why the last reload was refused. The watchdog is fed by watchdog.c. Loop
 * thread.
 */
#ifndef DX_NOTIFY_H
#define DX_NOTIFY_H

#include "core/base/err.h"

#define DX_NOTIFY_LINE 200 /* bytes, without the reason of a refusal */

struct dx_server;

/* Part of the server. */
struct dx_notify {
    char told[DX_NOTIFY_LINE]; /* the line that the manager has */
    struct dx_err refusal;     /* of the last reload; "": it was done */
};

void dx_notify_ready(struct dx_server *s);
void dx_notify_tick(struct dx_server *s); /* once a second: the line, if it is another one now */
void dx_notify_reloading(void);
/* `refusal` NULL: it was done. */
void dx_notify_reloaded(struct dx_server *s, const struct dx_err *refusal);
void dx_notify_stopping(void);

#endif
