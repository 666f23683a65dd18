/* Between the two halves of a simulated USB device: redir.c speaks usbredir, orders.c is the
 * program. */
#ifndef HIL_REDIR_PRIV_H
#define HIL_REDIR_PRIV_H

#include "tests/hil/redir.h"

#define REDIR_N_PORTS 2

/* `fd`: connected to QEMU, not blocking, one for each port. 0, or -ENOMEM. */
int redir_begin(const struct redir_device *device, const int fd[REDIR_N_PORTS]);
void redir_end(void);
/* The port that the device is in, from 1 on; 0: in none. */
unsigned redir_where(void);
/* What to poll a port's connection for, and what to do then; -1: QEMU has gone away. */
short redir_events(unsigned port);
int redir_dispatch(unsigned port, short revents);

#endif
