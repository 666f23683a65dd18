/* Between the parts of a simulated USB device: redir.c speaks usbredir, usb_answers.c knows
 * standard requests, orders.c is the program. */
#ifndef HIL_REDIR_PRIV_H
#define HIL_REDIR_PRIV_H

#include "tests/hil/redir.h"

#define REDIR_N_PORTS 2

/* bDescriptorType */
enum { TYPE_DEVICE = 1, TYPE_CONFIG = 2, TYPE_STRING = 3, TYPE_INTERFACE = 4, TYPE_ENDPOINT = 5 };

/* A control request: as control() of redir_device, whose affair it is when it is not standard. */
int redir_answer(const struct redir_device *device, const struct redir_setup *setup,
                 const uint8_t **bytes);

/* `fd`: connected to QEMU, not blocking, one for each port. 0, or -ENOMEM. */
int redir_begin(const struct redir_device *device, const int fd[REDIR_N_PORTS]);
void redir_end(void);
/* The port that the device is in, from 1 on; 0: in none. */
unsigned redir_where(void);
/* What to poll a port's connection for, and what to do then; -1: QEMU has gone away. */
short redir_events(unsigned port);
int redir_dispatch(unsigned port, short revents);

#endif
