/*
 * The loop thread: mesh socket, control socket, timers and signals of the service. All of it runs
 * inside dx_server_run, on the caller's thread; only dx_server_stop may be called from elsewhere.
 */
#ifndef DX_SERVER_H
#define DX_SERVER_H

#include <stdbool.h>

#include "core/base/err.h"
#include "daemon/counters.h"
#include "daemon/feed.h"

struct dx_device;
struct dx_heartbeats;
struct dx_recorder;
struct dx_server;
struct dx_stream_reader;

struct dx_server_options {
    const char *mesh_path; /* sockets to make; NULL: none. Inherited ones (sd_listen_fds, named */
    const char *control_path; /* "mesh" and "control") take their place */
    uint32_t max_clients;     /* 0: 256 */
    uint64_t hello_ns;        /* to say HELLO and SUBSCRIBE; 0: 5 s */
    uint64_t stall_ns;        /* without a byte of progress while data is owed; 0: 10 s */
    bool signals; /* SIGTERM and SIGINT end the loop; they must be blocked in all threads */
};

struct dx_server_stream_options {
    const char *name; /* all that is pointed to is borrowed and must outlive the server */
    struct dx_feed *feed;
    struct dx_counters *counters;
    bool lossless;                /* lossless subscribers are allowed */
    struct dx_recorder *recorder; /* for the control socket; NULL: none, also the next */
    struct dx_device *player;
    struct dx_stream_reader *reader;   /* poked by presence, for the status; NULL: none */
    const struct dx_heartbeats *beats; /* of its threads, for the watchdog; NULL: none */
    /* How many are subscribed now; called by the loop when that changes. May be NULL. */
    void (*subscribers)(void *ctx, uint32_t n);
    void *ctx;
};

/* Opens the sockets. Errors, with a text that names the path: -EADDRINUSE (a service answers
 * there), -EEXIST (not a socket), other -errno. */
int dx_server_new(struct dx_server **out, const struct dx_server_options *options,
                  struct dx_err *err);
void dx_server_free(struct dx_server *s); /* unlinks the sockets that it made */

/* Before dx_server_run. Errors: -EEXIST (a stream of that name), -ENOMEM. */
int dx_server_add_stream(struct dx_server *s, const struct dx_server_stream_options *stream);

/* Runs until stopped; then says so to the subscribers and returns within half a second. 0 or
 * -errno. */
int dx_server_run(struct dx_server *s);
void dx_server_stop(struct dx_server *s); /* any thread */

#endif
