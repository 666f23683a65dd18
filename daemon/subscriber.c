/* Life of a subscriber: what it says, its deadlines, its end. Loop thread. */
#include "daemon/server_priv.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <unistd.h>

#include "daemon/clock.h"
#include "daemon/limits.h"

#define TURN_BUDGET (256u << 10) /* bytes to one subscriber before the others have their turn */
#define NS_PER_MS   1000000u

static int on_io(sd_event_source *source, int fd, uint32_t revents, void *subscriber);

struct dx_log_about dx_subscriber_about(const struct dx_subscriber *s)
{
    return (struct dx_log_about){.stream = s->stream ? s->stream->options.name : NULL,
                                 .client_pid = s->cred.pid,
                                 .client_uid = s->cred.uid};
}

int dx_subscriber_new(struct dx_subscriber **out, struct dx_server *server, int fd,
                      const struct ucred *who)
{
    struct dx_subscriber *s = calloc(1, sizeof(*s));
    int r;

    if (!s) {
        close(fd);
        return -ENOMEM;
    }
    s->server = server;
    s->fd = fd;
    s->number = ++server->n_connections;
    s->hello_due_ns = dx_clock_ns() + server->options.hello_ns;
    s->cred = *who;
    s->io_events = EPOLLIN;
    r = sd_event_add_io(server->event, &s->io, fd, EPOLLIN, on_io, s);
    if (r < 0) {
        close(fd);
        free(s);
        return r;
    }
    dx_log_client(LOG_DEBUG, s, "connected");
    *out = s;
    return 0;
}

/* Gives back what belongs to the stream. */
static void leave(struct dx_subscriber *s)
{
    if (!s->stream)
        return;
    dx_outbox_cut(&s->out); /* what is left of a message is copied: the arena is let go of */
    dx_view_leave(&s->view, dx_clock_ns());
    dx_geometry_unref(s->geometry);
    s->geometry = NULL;
    dx_server_count_subscriber(s->stream, -1);
    s->stream = NULL;
}

static void disconnect(struct dx_subscriber *s)
{
    leave(s);
    s->io = sd_event_source_disable_unref(s->io);
    close(s->fd);
    s->fd = -1;
    s->phase = DX_SUBSCRIBER_CLOSED;
}

void dx_subscriber_free(struct dx_subscriber *s)
{
    if (!s)
        return;
    if (s->phase != DX_SUBSCRIBER_CLOSED)
        disconnect(s);
    dx_limits_let_go(s);
    free(s->out.own);
    free(s);
}

/* `more`: the turn ended before what is owed did. The outbox may be empty then (a piece of GEOMETRY
 * went whole), and without EPOLLOUT nothing would wake the loop for the next one. */
static void watch(struct dx_subscriber *s, bool more)
{
    uint32_t events = dx_outbox_is_empty(&s->out) && !more ? EPOLLIN : EPOLLIN | EPOLLOUT;

    if (events == s->io_events)
        return;
    s->io_events = events;
    sd_event_source_set_io_events(s->io, events);
}

/* ERROR, and the end: what the socket does not take at once is waited for where it may linger. */
static void say_error(struct dx_subscriber *s)
{
    struct dx_msg_error m = {.code = s->doomed};
    struct dx_writer w;

    if (s->said_error) { /* and it has gone */
        disconnect(s);
        return;
    }
    w = dx_outbox_begin(&s->out);
    memcpy(m.text, s->doom, sizeof(m.text));
    dx_msg_error_put(&w, &m);
    dx_outbox_end(&s->out, &w, DX_MSG_ERROR, DX_WIRE_NO_STREAM, 0, 0);
    s->said_error = true;
    s->progress_ns = dx_clock_ns();
    if (dx_outbox_write(&s->out, s->fd, TURN_BUDGET, dx_sender_sent, s) < 0 || !s->lingers ||
        dx_outbox_is_empty(&s->out))
        disconnect(s);
}

void dx_subscriber_shut(struct dx_subscriber *s, enum dx_wire_error code, const char *text,
                        bool linger)
{
    if (s->phase >= DX_SUBSCRIBER_CLOSING)
        return;
    s->doomed = (uint16_t)code;
    if (text != s->doom)
        snprintf(s->doom, sizeof(s->doom), "%s", text);
    if (code != DX_WIRE_E_SHUTDOWN)
        dx_log_client(LOG_INFO, s, "disconnected: %s", text);
    leave(s);
    s->phase = DX_SUBSCRIBER_CLOSING;
    if (s->tell_welcome) /* HELLO itself was fine */
        dx_sender_fill(s, dx_clock_ns());
    if (!dx_outbox_is_empty(&s->out) && s->fd >= 0)
        dx_outbox_write(&s->out, s->fd, TURN_BUDGET, dx_sender_sent, s);
    s->lingers = linger;
    if (dx_outbox_is_empty(&s->out))
        say_error(s);
    else if (!linger)
        disconnect(s);
    if (s->phase == DX_SUBSCRIBER_CLOSING)
        watch(s, false);
}

static void gone(struct dx_subscriber *s, const char *why)
{
    dx_log_client(LOG_DEBUG, s, "%s", why);
    disconnect(s);
}

/* ---- writing
 * ------------------------------------------------------------------------------------- */

void dx_subscriber_pump(struct dx_subscriber *s)
{
    size_t left = TURN_BUDGET;

    while (left && s->phase != DX_SUBSCRIBER_CLOSED) {
        ssize_t n;

        if (dx_outbox_is_empty(&s->out) && s->phase < DX_SUBSCRIBER_CLOSING)
            dx_sender_fill(s, dx_clock_ns());
        if (s->doomed && s->phase < DX_SUBSCRIBER_CLOSING)
            dx_subscriber_shut(s, s->doomed, s->doom, false);
        else if (dx_outbox_is_empty(&s->out) && s->phase == DX_SUBSCRIBER_CLOSING)
            say_error(s);
        if (s->phase == DX_SUBSCRIBER_CLOSED || dx_outbox_is_empty(&s->out))
            break;
        n = dx_outbox_write(&s->out, s->fd, left, dx_sender_sent, s);
        if (n < 0)
            gone(s, strerror((int)-n));
        if (n <= 0)
            break;
        s->progress_ns = dx_clock_ns();
        s->n_bytes += (uint64_t)n;
        left -= (size_t)n < left ? (size_t)n : left;
    }
    if (s->phase != DX_SUBSCRIBER_CLOSED)
        watch(s, left == 0);
}

bool dx_subscriber_wants_batch(const struct dx_subscriber *s, uint64_t now_ns)
{
    if (s->phase != DX_SUBSCRIBER_STREAMING || s->stage != DX_BATCH_NONE || s->tell_subscribed ||
        s->geometry || !dx_view_ready(&s->view))
        return false;
    if (s->asked.mode == DX_MODE_PULL && s->credit == 0)
        return false;
    return s->asked.mode == DX_MODE_LOSSLESS || s->batch_ns == 0 ||
           now_ns - s->batch_ns >= (uint64_t)s->asked.min_interval_ms * NS_PER_MS;
}

/* ---- deadlines
 * ----------------------------------------------------------------------------------- */

static bool waits_for_words(const struct dx_subscriber *s)
{
    return s->phase == DX_SUBSCRIBER_HELLO || s->phase == DX_SUBSCRIBER_SUBSCRIBE;
}

uint64_t dx_subscriber_due(const struct dx_subscriber *s)
{
    uint64_t due = waits_for_words(s) ? s->hello_due_ns : UINT64_MAX;

    if (!dx_outbox_is_empty(&s->out)) {
        if (s->progress_ns + s->server->options.stall_ns < due)
            due = s->progress_ns + s->server->options.stall_ns;
    } else if (dx_subscriber_wants_batch(s, UINT64_MAX)) { /* waits for its interval, or a pin */
        uint64_t interval = s->batch_ns + (uint64_t)s->asked.min_interval_ms * NS_PER_MS;
        uint64_t patience = dx_view_patience(&s->view);

        due = interval > patience ? interval : patience;
    }
    return due;
}

void dx_subscriber_tick(struct dx_subscriber *s, uint64_t now_ns)
{
    if (s->phase == DX_SUBSCRIBER_CLOSED)
        return;
    if (waits_for_words(s) && now_ns >= s->hello_due_ns)
        dx_subscriber_shut(s, DX_WIRE_E_PROTOCOL, "no HELLO and SUBSCRIBE in time", false);
    else if (!dx_outbox_is_empty(&s->out) &&
             now_ns >= s->progress_ns + s->server->options.stall_ns) {
        dx_subscriber_shut(s, DX_WIRE_E_SLOW, "not a byte taken for too long", false);
        if (s->phase == DX_SUBSCRIBER_CLOSING)
            disconnect(s);
    }
}

/* ---- what it says
 * -------------------------------------------------------------------------------- */

static void refuse(struct dx_subscriber *s, enum dx_wire_error code, const char *text)
{
    dx_subscriber_shut(s, code, text, false);
}

static void on_hello(struct dx_subscriber *s, const uint8_t *body, size_t len)
{
    char text[DX_WIRE_TEXT];
    struct dx_msg_hello m;

    if (dx_msg_hello_get(&m, body, len) < 0) {
        refuse(s, DX_WIRE_E_PROTOCOL, "not a HELLO");
        return;
    }
    if (m.major != DX_WIRE_MAJOR) {
        snprintf(text, sizeof(text),
                 "found protocol %u.%u, expected %d.x: take a client of that version", m.major,
                 m.minor, DX_WIRE_MAJOR);
        refuse(s, DX_WIRE_E_VERSION, text);
        return;
    }
    s->encodings = m.encodings & ((1u << DX_N_ENCODINGS) - 1);
    if (!s->encodings) {
        refuse(s, DX_WIRE_E_ENCODING, "no encoding in common; there are f32, q16 and delta");
        return;
    }
    s->minor = dx_wire_minor(m.minor);
    s->tell_welcome = true;
    s->phase = DX_SUBSCRIBER_SUBSCRIBE;
}

static struct dx_server_stream *find_stream(struct dx_server *server, const char *name)
{
    struct dx_server_stream *st = server->streams;

    if (!*name)
        return server->n_streams == 1 ? st : NULL;
    while (st && strcmp(st->options.name, name))
        st = st->next;
    return st;
}

/* "no stream 'x'; there are: a, b", as many names as fit; or that it has to name one. */
static void name_streams(char *text, size_t len, const struct dx_subscriber *s)
{
    int n = *s->asked.stream || s->server->n_streams == 0
                ? snprintf(text, len, "no stream '%s'; there are:", s->asked.stream)
                : snprintf(text, len, "no stream was named, and there are several:");

    for (const struct dx_server_stream *st = s->server->streams; st; st = st->next)
        if (n > 0 && (size_t)n < len)
            n += snprintf(text + n, len - (size_t)n, "%s %s", st == s->server->streams ? "" : ",",
                          st->options.name);
    for (char *p = text; *p; p++) /* the name that was asked for may be any bytes */
        *p = *p & (char)0x80 ? '?' : *p;
}

static int join(struct dx_subscriber *s, struct dx_server_stream *st, unsigned form)
{
    const struct dx_msg_subscribe *m = &s->asked;

    s->out.own = malloc(DX_OUTBOX_OWN);
    if (!s->out.own)
        return -ENOMEM;
    s->out.feed = st->options.feed;
    s->view.loop = st->loop;
    s->view.form = form;
    s->view.lossless = m->mode == DX_MODE_LOSSLESS;
    s->view.region =
        (struct dx_view_region){m->tile_row0, m->tile_col0, m->n_tile_rows, m->n_tile_cols};
    s->view.dropped = dx_sender_dropped;
    return dx_view_join(&s->view);
}

/* As many as fit. */
static void name_levels(char *text, size_t len, const struct dx_feed_loop *l)
{
    int n = snprintf(text, len, "%d other levels of detail are in use; take one of:", DX_LOD_SLOTS);

    for (unsigned s = 0; s < DX_LOD_SLOTS; s++) {
        const struct dx_lod_level level = l->level[s];

        if (n > 0 && (size_t)n < len)
            n += snprintf(text + n, len - (size_t)n, "%s bound %g stride %u", s ? "," : "",
                          (double)level.bound / DX_LOD_PER_SIGMA, level.stride);
    }
}

/* The form that a client asks for; DX_N_FORMS having refused it. */
static unsigned form_asked(struct dx_subscriber *s, struct dx_server_stream *st)
{
    const struct dx_msg_subscribe *m = &s->asked;
    char text[DX_WIRE_TEXT];
    unsigned form;

    if (dx_lod_is_whole(m->lod))
        return m->encoding;
    if (dx_lod_check(m->lod)) {
        refuse(s, DX_WIRE_E_PROTOCOL, dx_lod_check(m->lod));
        return DX_N_FORMS;
    }
    if (dx_encoding_has_ranges(m->encoding)) {
        refuse(s, DX_WIRE_E_ENCODING,
               "q16 and delta carry whole cells, no level of detail; take f32");
        return DX_N_FORMS;
    }
    form = dx_feed_loop_form(st->loop, m->lod);
    if (form == DX_N_FORMS) {
        name_levels(text, sizeof(text), st->loop);
        refuse(s, DX_WIRE_E_LIMIT, text);
    }
    return form;
}

void dx_subscriber_is_behind(struct dx_subscriber *s)
{
    if (!s->behind_ns)
        s->behind_ns = dx_clock_ns();
}

static void subscribe(struct dx_subscriber *s, struct dx_server_stream *st)
{
    const unsigned form = form_asked(s, st);
    char why[DX_WIRE_TEXT];

    if (form == DX_N_FORMS)
        return;
    if (!dx_limits_take(s, DX_OUTBOX_OWN + dx_view_len(st->loop), why)) {
        refuse(s, DX_WIRE_E_LIMIT, why);
        return;
    }
    if (join(s, st, form) < 0) {
        refuse(s, DX_WIRE_E_LIMIT, "no memory for another subscriber");
        return;
    }
    s->stream = st;
    s->tell_subscribed = s->tell_state = true;
    s->phase = DX_SUBSCRIBER_STREAMING;
    if (st->loop->has_epoch)
        dx_subscriber_is_behind(s);
    dx_server_count_subscriber(st, 1);
    dx_log_client(LOG_INFO, s, "subscribed to %s, %s, %s", st->options.name,
                  dx_encoding_name(s->asked.encoding), dx_mode_name(s->asked.mode));
}

static void on_subscribe(struct dx_subscriber *s, const uint8_t *body, size_t len)
{
    struct dx_server_stream *st;
    char text[DX_WIRE_TEXT];

    if (dx_msg_subscribe_get(&s->asked, body, len) < 0) {
        refuse(s, DX_WIRE_E_PROTOCOL, "not a SUBSCRIBE, or a value in it is out of range");
        return;
    }
    st = find_stream(s->server, s->asked.stream);
    if (!st) {
        name_streams(text, sizeof(text), s);
        refuse(s, DX_WIRE_E_NO_STREAM, text);
    } else if (!(s->encodings & 1u << s->asked.encoding)) {
        refuse(s, DX_WIRE_E_ENCODING, "an encoding that HELLO did not name");
    } else if (s->asked.mode == DX_MODE_LOSSLESS && !st->options.lossless) {
        refuse(s, DX_WIRE_E_MODE, "lossless is only for a replay at rate max");
    } else {
        subscribe(s, st);
    }
}

static void on_next(struct dx_subscriber *s, size_t len)
{
    if (s->asked.mode != DX_MODE_PULL || len != 0)
        refuse(s, DX_WIRE_E_PROTOCOL, "NEXT, which has no body, is for pull mode");
    else if (s->credit < UINT32_MAX)
        s->credit++;
}

static void on_message(struct dx_subscriber *s, const struct dx_wire_header *h, const uint8_t *body)
{
    char text[DX_WIRE_TEXT];

    if (s->phase == DX_SUBSCRIBER_HELLO && h->type == DX_MSG_HELLO) {
        on_hello(s, body, h->length);
    } else if (s->phase == DX_SUBSCRIBER_SUBSCRIBE && h->type == DX_MSG_SUBSCRIBE) {
        on_subscribe(s, body, h->length);
    } else if (s->phase == DX_SUBSCRIBER_STREAMING && h->type == DX_MSG_NEXT) {
        on_next(s, h->length);
    } else if (s->phase == DX_SUBSCRIBER_HELLO || h->type <= DX_MSG_NEXT ||
               !(h->flags & DX_WIRE_SKIPPABLE)) {
        snprintf(text, sizeof(text), "message type %u is not expected here", h->type);
        refuse(s, DX_WIRE_E_PROTOCOL, text);
    }
}

/* Handles the whole messages at the front of the buffer. */
static void parse(struct dx_subscriber *s)
{
    size_t at = 0;

    while (s->phase < DX_SUBSCRIBER_CLOSING && s->in_len - at >= DX_WIRE_HEADER_LEN) {
        struct dx_wire_header h;
        char text[DX_WIRE_TEXT];

        dx_wire_get_header(&h, s->in + at);
        if (h.length > DX_WIRE_MAX_CLIENT_BODY) {
            snprintf(text, sizeof(text), "found a body of %u bytes, expected at most %u", h.length,
                     DX_WIRE_MAX_CLIENT_BODY);
            refuse(s, DX_WIRE_E_PROTOCOL, text);
            return;
        }
        if (s->in_len - at < DX_WIRE_HEADER_LEN + h.length)
            break;
        on_message(s, &h, s->in + at + DX_WIRE_HEADER_LEN);
        at += DX_WIRE_HEADER_LEN + h.length;
    }
    memmove(s->in, s->in + at, s->in_len - at);
    s->in_len -= at;
}

/* One buffer a turn: a client that talks without end has its share like the others. */
static void receive(struct dx_subscriber *s)
{
    ssize_t n = recv(s->fd, s->in + s->in_len, sizeof(s->in) - s->in_len, MSG_DONTWAIT);

    if (n == 0) {
        gone(s, "closed the connection");
    } else if (n < 0) {
        if (errno != EAGAIN && errno != EINTR)
            gone(s, strerror(errno));
    } else {
        s->in_len += (size_t)n;
        if (s->phase == DX_SUBSCRIBER_CLOSING)
            s->in_len = 0;
        parse(s);
    }
}

static int on_io(sd_event_source *source, int fd, uint32_t revents, void *subscriber)
{
    struct dx_subscriber *s = subscriber;

    (void)source;
    (void)fd;
    if (revents & (EPOLLIN | EPOLLHUP | EPOLLERR))
        receive(s);
    if (s->phase != DX_SUBSCRIBER_CLOSED)
        dx_subscriber_pump(s);
    return 0;
}
