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

#define DX_SERVER_PATH 112 /* of a socket, as a text */

struct dx_device;
struct dx_heartbeats;
struct dx_recorder;
struct dx_server;
struct dx_server_stream;
struct dx_stream_reader;
struct sd_event;

/* Of what clients may take; 0: the default. */
struct dx_server_limits {
    uint32_t max_clients;         /* 256 */
    uint32_t max_clients_per_uid; /* as many as max_clients */
    uint64_t client_memory;       /* bytes that subscribers hold, in all; 256 MiB */
    uint32_t max_requests;        /* a second, on the control socket; 100 */
};

struct dx_server_options {
    const char *mesh_path; /* sockets to make; NULL: none. Inherited ones (sd_listen_fds, named */
    const char *control_path; /* "mesh" and "control") take their place */
    struct dx_server_limits limits;
    uint64_t hello_ns;        /* to say HELLO and SUBSCRIBE; 0: 5 s */
    uint64_t stall_ns;        /* without a byte of progress while data is owed; 0: 10 s */
    const char *metrics_file; /* metrics_file.h; NULL or "": none */
    uint32_t metrics_s;
    bool signals; /* SIGTERM and SIGINT end the loop, SIGHUP asks for a reload; they must be blocked
                     in all threads */
    /* Reads the configuration again: starts to, and returns the number of the reload that will have
     * what the file holds now; dx_server_tell_reload says when. 0: there is no file. May be NULL.
     */
    uint64_t (*reload)(void *ctx);
    /* Has one been under way for long, for a stream whose source does not open? May be NULL. */
    bool (*reload_waits)(void *ctx, char stream[64]);
    /* The configuration in force as YAML, to be freed. NULL: no memory. May be NULL. */
    char *(*config)(void *ctx);
    void *ctx;
};

struct dx_server_stream_options {
    const char *name; /* all that is pointed to is borrowed, and must outlive this stream here */
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
/* Which of its sockets it has inherited. */
void dx_server_inherits(const struct dx_server *s, bool *mesh, bool *control);
/* Where they are; "none". */
void dx_server_paths(const struct dx_server *s, char mesh[DX_SERVER_PATH],
                     char control[DX_SERVER_PATH]);
void dx_server_free(struct dx_server *s); /* unlinks the sockets that it made */

/* Before dx_server_run. Errors: -EEXIST (a stream of that name), -ENOMEM. */
int dx_server_add_stream(struct dx_server *s, const struct dx_server_stream_options *stream);

/* ---- streams that come and go while it runs ----------------------------------------------------
 * Making one takes time and is any thread's; then the loop's thread attaches it, which can fail,
 * and puts it in its place, which cannot. What it gives up, any thread may free.
 */

/* -ENOMEM. Until it is freed, `options` must hold what they point to. */
int dx_server_stream_new(struct dx_server_stream **out,
                         const struct dx_server_stream_options *options);
void dx_server_stream_free(struct dx_server_stream *st); /* not attached. NULL is fine */

/* Watches its feed and its device. -errno. */
int dx_server_attach_stream(struct dx_server *s, struct dx_server_stream *st);
void dx_server_detach_stream(struct dx_server_stream *st); /* never put */

/* Serves an attached one. Subscribers of the stream that had its name are told RESET with the
 * reason, and stay; that one is returned, detached. NULL: there was none. */
struct dx_server_stream *dx_server_put_stream(struct dx_server *s, struct dx_server_stream *st,
                                              const char *reason);
/* Serves it no more: its subscribers get ERROR "no stream" with the reason. Returned detached;
 * NULL: there is none. */
struct dx_server_stream *dx_server_take_stream(struct dx_server *s, const char *name,
                                               const char *reason);

/* For those who come; who is there stays. */
void dx_server_set_limits(struct dx_server *s, const struct dx_server_limits *limits);

struct sd_event *dx_server_event(struct dx_server *s);

/* Runs until stopped; then says so to the subscribers and returns within half a second. 0 or
 * -errno. */
int dx_server_run(struct dx_server *s);
void dx_server_stop(struct dx_server *s); /* any thread */

#endif
