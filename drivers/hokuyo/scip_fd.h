/*
 * Links over a file descriptor: what a tty and a TCP connection have in common. Reader thread, save
 * wake().
 */
#ifndef DX_SCIP_FD_H
#define DX_SCIP_FD_H

#include "drivers/hokuyo/scip_link.h"

struct dx_scip_fd {
    struct dx_scip_link link;
    int fd; /* -1: not open; does not block */
    int wake_fd;
};

/* A link that is open. Takes the fd, also when it fails. -ENOMEM, or from eventfd. */
int dx_scip_link_new_fd(struct dx_scip_link **out, int fd, const char *place, struct dx_err *err);

/* ---- for links that hold one ------------------------------------------------------------------
 */

/* fd is -1 then. From eventfd. */
int dx_scip_fd_init(struct dx_scip_fd *l, const struct dx_scip_link_ops *ops, const char *place,
                    struct dx_err *err);
void dx_scip_fd_fini(struct dx_scip_fd *l);
int dx_scip_fd_write(struct dx_scip_link *link, const uint8_t *bytes, size_t len,
                     struct dx_err *err);
int dx_scip_fd_read(struct dx_scip_link *link, uint8_t *bytes, size_t cap, size_t *len,
                    int timeout_ms, struct dx_err *err);
void dx_scip_fd_wake(struct dx_scip_link *link);
/* Waits until the fd can be read or written (POLLIN, POLLOUT). 0; AGAIN: woken, or the time ran
 * out; negative. */
int dx_scip_fd_wait(struct dx_scip_fd *l, short events, int timeout_ms, struct dx_err *err);

#endif
