/* What the files of the loop thread share: server.c, server_streams.c, subscriber.c, sender.c,
 * listen.c, control.c, status.c. */
#ifndef DX_SERVER_PRIV_H
#define DX_SERVER_PRIV_H

#include <sys/types.h>
#include <systemd/sd-event.h>

#include "daemon/heartbeat.h"
#include "daemon/latency.h"
#include "daemon/log.h"
#include "daemon/notify.h"
#include "daemon/presence.h"
#include "daemon/server.h"
#include "daemon/subscriber.h"

#define DX_SERVER_ACCEPT_PAUSE_NS 100000000u /* when out of descriptors */

struct dx_control;
struct dx_metrics_file;
struct dx_probe;
struct dx_watchdog;

struct dx_server_stream {
    struct dx_server *server;
    struct dx_server_stream *next;
    struct dx_server_stream_options options;
    uint32_t number;
    struct dx_feed_loop *loop;
    sd_event_source *wake;
    uint32_t n_subscribers;
    bool hangs[DX_N_BEATS];    /* as the watchdog found its threads last */
    struct dx_latency latency; /* host stamp of the frame to COMMIT handed to the kernel */
    struct dx_latency stage[DX_N_STAGES]; /* its parts: an epoch each, of SEND a batch each */
    /* frames a second, over the last second or so */
    uint64_t rate_ns, rate_frames;
    double frames_per_s;
    uint64_t newest_ns; /* when the data of the newest mesh were read; 0: not known */
};

struct dx_listener {
    int fd;     /* -1: none */
    char *made; /* path to unlink; NULL: inherited */
    dev_t dev;  /* which file that was */
    ino_t ino;
    int lock_fd; /* PATH.lock, held; -1: none */
    char *lock_name;
    sd_event_source *io;
};

struct dx_server {
    struct dx_server_options options;
    sd_event *event;
    int stop_fd;
    sd_event_source *timer, *post;
    struct dx_listener mesh;
    struct dx_control *control;
    struct dx_probe *probe; /* of the control socket; NULL without one */
    struct dx_presence *presence;
    struct dx_watchdog *watchdog;
    struct dx_metrics_file *metrics; /* NULL: none */
    struct dx_notify notify;
    uint64_t accept_again_ns; /* 0: accepting */
    uint64_t tick_due_ns;
    uint64_t exit_due_ns; /* 0: not stopping */
    uint64_t started_ns;
    struct dx_server_stream *streams;
    uint32_t n_streams;
    uint32_t next_number; /* of a stream: none is used again, or a client could mix two up */
    struct dx_subscriber *subscribers;
    uint32_t n_clients;
    uint64_t held_len; /* bytes that subscribers hold: limits.h */
    uint64_t n_connections;
};

/* As options.reload; 0 too while the service stops. */
uint64_t dx_server_reload(struct dx_server *s);

/* A subscriber came (+1) or went (-1). */
void dx_server_count_subscriber(struct dx_server_stream *st, int by);

/* After an event; once a second; at the end, when no subscriber is left. */
void dx_server_settle_streams(struct dx_server *s);
void dx_server_tick_streams(struct dx_server *s, uint64_t now_ns);
void dx_server_free_streams(struct dx_server *s);

/* A line about a subscriber, which names it. */
#define dx_log_client(level, s, fmt, ...)                                                          \
    do {                                                                                           \
        struct dx_log_about was = dx_log_about(dx_subscriber_about(s));                            \
        dx_log_at(level, "server", "client %llu (pid %d uid %u): " fmt,                            \
                  (unsigned long long)(s)->number, (int)(s)->cred.pid, (unsigned)(s)->cred.uid,    \
                  ##__VA_ARGS__);                                                                  \
        dx_log_about(was);                                                                         \
    } while (0)

/* Makes the socket at `path` with mode 0660, or takes the inherited one of that `name`; neither: -1
 * in l->fd. Errors as dx_server_new. */
int dx_listener_open(struct dx_listener *l, const char *path, const char *name, struct dx_err *err);
void dx_listener_close(struct dx_listener *l);

/* Where it listens, inherited or not. */
void dx_listener_tell(const struct dx_listener *l, char path[DX_SERVER_PATH]);

static inline bool dx_listener_is_inherited(const struct dx_listener *l)
{
    return l->fd >= 0 && !l->made;
}

#endif
