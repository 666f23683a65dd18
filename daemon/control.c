/* Connections of the control socket. Loop thread. */
#include "daemon/control.h"

#include <errno.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <unistd.h>

#include "daemon/clock.h"
#include "daemon/control_devices.h"
#include "daemon/control_requests.h"
#include "daemon/log.h"
#include "daemon/server_priv.h"

#define MAX_CONNECTIONS 16
#define MAX_LINE        1024
#define TEXT(n)         #n
#define BOUND(n)        TEXT(n)

struct connection {
    struct dx_control *control;
    int fd; /* -1: free */
    struct ucred cred;
    uint64_t number; /* in the order of their coming */
    sd_event_source *io;
    char in[MAX_LINE];
    size_t in_len;
    struct dx_control_wait waits; /* for an answer that comes later: nothing is read until then */
    char *out;                    /* a reply; nothing is read until it is gone */
    size_t out_len, out_at;
};

struct dx_control {
    struct dx_server *server;
    struct dx_listener listener;
    uint64_t n_connections;
    uint64_t second; /* of the clock, and the requests in it */
    uint32_t n_requests;
    struct dx_probe *probe;
    struct connection connection[MAX_CONNECTIONS];
};

static void hang_up(struct connection *c)
{
    c->io = sd_event_source_disable_unref(c->io);
    if (c->fd >= 0)
        close(c->fd);
    free(c->out);
    c->out = NULL;
    c->fd = -1;
    c->waits = (struct dx_control_wait){0};
}

/* A text that says which bound was met, as far as the socket takes it at once, and the end. */
static void turn_away(struct connection *c, const char *why)
{
    char line[200];
    int len = snprintf(line, sizeof(line), "{\"error\":\"%s\"}\n", why);

    dx_log_warning("control", "pid %d uid %u: %s", (int)c->cred.pid, (unsigned)c->cred.uid, why);
    if (!c->out)
        (void)!send(c->fd, line, (size_t)len, MSG_NOSIGNAL | MSG_DONTWAIT);
    hang_up(c);
}

/* May one more be asked in this second? */
static bool may_ask(struct dx_control *k)
{
    uint64_t second = dx_clock_ns() / 1000000000u;

    if (second != k->second)
        k->n_requests = 0;
    k->second = second;
    return ++k->n_requests <= k->server->options.limits.max_requests;
}

static json_t *refuse(const struct connection *c)
{
    dx_log_warning("control", "pid %d uid %u: too many requests", (int)c->cred.pid,
                   (unsigned)c->cred.uid);
    return json_pack("{s:o}", "error",
                     json_sprintf("too many requests: %u a second (max_requests)",
                                  c->control->server->options.limits.max_requests));
}

/* What a line is answered with: a new reference. NULL: no memory; or, with c->waits set, later. */
static json_t *answer(struct connection *c, const char *line, size_t len)
{
    json_error_t where;
    json_t *request, *reply;

    if (!may_ask(c->control))
        return refuse(c);
    request = json_loadb(line, len, JSON_REJECT_DUPLICATES, &where);
    if (request)
        reply = dx_control_answer(c->control->server, request, &c->cred, &c->waits);
    else
        reply = json_pack("{s:o}", "error", json_sprintf("not JSON: %s", where.text));
    json_decref(request);
    return reply;
}

/* Writes what is left of the reply; false: the connection is no more. */
static bool write_reply(struct connection *c)
{
    ssize_t n =
        send(c->fd, c->out + c->out_at, c->out_len - c->out_at, MSG_NOSIGNAL | MSG_DONTWAIT);

    if (n < 0 && errno != EAGAIN && errno != EINTR) {
        hang_up(c);
        return false;
    }
    c->out_at += n > 0 ? (size_t)n : 0;
    if (c->out_at == c->out_len) {
        free(c->out);
        c->out = NULL;
    }
    sd_event_source_set_io_events(c->io, c->out ? EPOLLOUT : EPOLLIN);
    return true;
}

/* Takes the reference. False: the connection is no more. */
static bool reply_with(struct connection *c, json_t *reply)
{
    c->out = reply ? json_dumps(reply, JSON_COMPACT) : NULL;
    json_decref(reply);
    if (!c->out) {
        hang_up(c);
        return false;
    }
    c->out_len = strlen(c->out) + 1;
    c->out[c->out_len - 1] = '\n'; /* in place of the NUL: from here on it is bytes */
    c->out_at = 0;
    return write_reply(c);
}

/* No line of text begins so; HELLO of the mesh protocol does, in which no newline may come. */
static bool is_no_text(const struct connection *c)
{
    const unsigned char first = c->in_len ? (unsigned char)c->in[0] : ' ';

    return first < ' ' && first != '\t' && first != '\n' && first != '\r';
}

/* Answers the lines that are there, one after the other. */
static void answer_lines(struct connection *c)
{
    char *end;

    while (!c->out && !c->waits.topic && !is_no_text(c) && (end = memchr(c->in, '\n', c->in_len))) {
        size_t len = (size_t)(end - c->in) + 1;
        json_t *reply = answer(c, c->in, len - 1);

        memmove(c->in, c->in + len, c->in_len - len);
        c->in_len -= len;
        if (c->waits.topic)
            sd_event_source_set_io_events(c->io, 0); /* only its end is noticed */
        else if (!reply_with(c, reply))
            return;
    }
    if (c->out || c->waits.topic)
        return;
    if (is_no_text(c))
        turn_away(c, "found a control byte, expected a line of JSON: this is the control socket, "
                     "meshes come from the mesh socket");
    else if (c->in_len == sizeof(c->in))
        turn_away(c, "too long a request: at most " BOUND(MAX_LINE) " bytes");
}

static void on_devices(void *control, json_t *reply)
{
    dx_control_tell(control, (struct dx_control_wait){DX_TOPIC_DEVICES, DX_CONTROL_DEVICES}, reply);
    json_decref(reply);
}

static int on_connection(sd_event_source *source, int fd, uint32_t revents, void *connection)
{
    struct connection *c = connection;
    ssize_t n;

    (void)source;
    if (c->waits.topic) {
        hang_up(c);
        return 0;
    }
    if (c->out) {
        if (revents & (EPOLLERR | EPOLLHUP))
            hang_up(c);
        else if (write_reply(c))
            answer_lines(c);
        return 0;
    }
    n = recv(fd, c->in + c->in_len, sizeof(c->in) - c->in_len, MSG_DONTWAIT);
    if (n > 0) {
        c->in_len += (size_t)n;
        answer_lines(c);
    } else if (n == 0 || (errno != EAGAIN && errno != EINTR)) {
        hang_up(c);
    }
    return 0;
}

/* A free place; else that of the connection that has been here longest, which gives way. */
static struct connection *make_room(struct dx_control *k)
{
    struct connection *oldest = k->connection;

    for (struct connection *c = k->connection; c < k->connection + MAX_CONNECTIONS; c++) {
        if (c->fd < 0)
            return c;
        if (c->number < oldest->number)
            oldest = c;
    }
    turn_away(oldest, "another connection came, and there are " BOUND(MAX_CONNECTIONS) " at most");
    return oldest;
}

static int on_accept(sd_event_source *source, int fd, uint32_t revents, void *control)
{
    struct dx_control *k = control;
    struct connection *c;
    socklen_t len = sizeof(c->cred);
    int client = accept4(fd, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);

    (void)revents;
    if (client < 0) {
        if (errno != EAGAIN) /* out of descriptors: look away until dx_control_resume */
            sd_event_source_set_enabled(source, SD_EVENT_OFF);
        return 0;
    }
    c = make_room(k);
    *c = (struct connection){.control = k, .fd = client, .number = ++k->n_connections};
    if (getsockopt(client, SOL_SOCKET, SO_PEERCRED, &c->cred, &len) < 0)
        c->cred = (struct ucred){0, (uid_t)-1, (gid_t)-1};
    if (sd_event_add_io(k->server->event, &c->io, client, EPOLLIN, on_connection, c) < 0)
        hang_up(c);
    return 0;
}

int dx_control_new(struct dx_control **out, struct dx_server *server, const char *path,
                   struct dx_err *err)
{
    struct dx_control *k = calloc(1, sizeof(*k));
    int r;

    *out = NULL;
    if (!k)
        return dx_err_set(err, -ENOMEM, "no memory");
    k->server = server;
    for (int n = 0; n < MAX_CONNECTIONS; n++)
        k->connection[n].fd = -1;
    r = dx_listener_open(&k->listener, path, "control", err);
    if (r == 0) {
        r = dx_probe_new(&k->probe, server, on_devices, k);
        server->probe = k->probe;
        if (r == 0 && k->listener.fd >= 0)
            r = sd_event_add_io(server->event, &k->listener.io, k->listener.fd, EPOLLIN, on_accept,
                                k);
        if (r < 0)
            dx_err_set(err, r, "event loop: %s", strerror(-r));
    }
    if (r < 0) {
        dx_control_free(k);
        return r;
    }
    *out = k;
    return 0;
}

void dx_control_tell(struct dx_control *k, struct dx_control_wait done, json_t *reply)
{
    for (int n = 0; k && n < MAX_CONNECTIONS; n++) {
        struct connection *c = &k->connection[n];

        if (c->fd < 0 || c->waits.topic != done.topic || c->waits.number > done.number)
            continue;
        c->waits = (struct dx_control_wait){0};
        if (reply_with(c, json_incref(reply)))
            answer_lines(c);
    }
}

bool dx_control_is_inherited(const struct dx_control *k)
{
    return k && dx_listener_is_inherited(&k->listener);
}

void dx_control_path(const struct dx_control *k, char path[DX_SERVER_PATH])
{
    const struct dx_listener none = {.fd = -1};

    dx_listener_tell(k ? &k->listener : &none, path);
}

void dx_control_resume(struct dx_control *k)
{
    if (k && k->listener.io)
        sd_event_source_set_enabled(k->listener.io, SD_EVENT_ON);
}

void dx_control_free(struct dx_control *k)
{
    if (!k)
        return;
    for (int n = 0; n < MAX_CONNECTIONS; n++)
        hang_up(&k->connection[n]);
    dx_listener_close(&k->listener);
    k->server->probe = NULL;
    dx_probe_free(k->probe);
    free(k);
}
