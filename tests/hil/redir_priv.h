/* Between the two halves of a simulated USB device: redir.c speaks usbredir, orders.c is the
 * program. */
#ifndef HIL_REDIR_PRIV_H
#define HIL_REDIR_PRIV_H

#include "tests/hil/redir.h"

/* `fd`: connected to QEMU, not blocking. 0, or -ENOMEM. */
int redir_begin(const struct redir_device *device, int fd);
void redir_end(void);
bool redir_is_in(void);
/* What to poll for, and what to do then; -1: QEMU has gone away. */
short redir_events(void);
int redir_dispatch(short revents);

#endif
