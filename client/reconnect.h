/*
 * A subscription that outlives its service: when a connection is lost, another is tried by and by.
 * The descriptor that the user polls stays the same: an epoll instance of the socket and a timer.
 * Belongs to the thread that drives the connection.
 */
#ifndef DX_RECONNECT_H
#define DX_RECONNECT_H

#include <stdbool.h>
#include <stdint.h>

struct dexel;

struct dx_reconnect {
    int poll_fd, timer_fd; /* -1: not asked for */
    char path[108];        /* of the service */
    uint32_t n_tries;      /* since a service served us */
    bool is_lost;          /* the mesh that is held was of a connection that is no more */
    bool is_told;          /* that there is none */
};

void dx_reconnect_init(struct dx_reconnect *r);
void dx_reconnect_fini(struct dx_reconnect *r);

/* Asked for; the first try is due at once. Errors, with text: -ENAMETOOLONG, -errno. */
int dx_reconnect_start(struct dexel *d, const char *path);

/* What dexel_dispatch() does when it was asked for: its result. */
int dx_reconnect_dispatch(struct dexel *d);

/* The server has welcomed us: the mesh of the connection before is void. A callback's value. */
int dx_reconnect_welcomed(struct dexel *d);

/* It has taken the subscription. One that is full welcomes us as well, to say that: tries go on
 * getting rarer then. */
void dx_reconnect_served(struct dexel *d);

#endif
