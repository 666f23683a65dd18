/*
 * The streams of a server: each has a feed, whose loop half is here, and the subscribers that are
 * on it. They come, are replaced and go while the loop runs. Loop thread; making and freeing one
 * that is not served is any thread's.
 */
#include "daemon/server_priv.h"

#include <assert.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <unistd.h>

#include "daemon/reader.h"

#define PRIORITY_FEED (-10) /* adoption first: it frees chunks for the mesher */

void dx_server_count_subscriber(struct dx_server_stream *st, int by)
{
    st->n_subscribers += (uint32_t)by;
    if (st->options.subscribers)
        st->options.subscribers(st->options.ctx, st->n_subscribers);
}

static void wake_again(struct dx_server_stream *st)
{
    uint64_t one = 1;
    ssize_t r = write(st->options.feed->wake_fd, &one, sizeof(one));

    (void)r; /* EAGAIN: it is awake */
}

/* Stations are passed in this order; a device may stamp what it reads by a clock of its own. */
static void count_passage(struct dx_server_stream *st, const struct dx_passage *p)
{
    const uint64_t at[] = {p->read_ns, p->delivered_ns, p->taken_ns, p->meshed_ns, p->published_ns};

    if (p->read_ns)
        st->newest_ns = p->read_ns;
    for (int k = 0; p->read_ns && k < DX_STAGE_SEND; k++)
        if (at[k] <= at[k + 1])
            dx_latency_add(&st->stage[k], at[k + 1] - at[k]);
}

static void serve_stream(struct dx_server_stream *st)
{
    unsigned found = dx_feed_loop_turn(st->loop);

    if (!found)
        return;
    if (found & DX_FEED_NEW_EPOCH)
        count_passage(st, &st->loop->passage);
    for (struct dx_subscriber *s = st->server->subscribers; s; s = s->next) {
        if (s->stream != st)
            continue;
        if (found & DX_FEED_NEW_STATE)
            s->tell_state = true;
        if (found & DX_FEED_NEW_EPOCH)
            dx_subscriber_is_behind(s);
        dx_subscriber_pump(s);
    }
}

static int on_feed(sd_event_source *source, int fd, uint32_t revents, void *stream)
{
    struct dx_server_stream *st = stream;
    uint64_t n;
    ssize_t r = read(fd, &n, sizeof(n));

    (void)source;
    (void)revents;
    (void)r;
    serve_stream(st);
    return 0;
}

static void poke_reader(void *reader)
{
    dx_reader_device_poke(dx_stream_reader_attached(reader));
}

static int watch_device(struct dx_server_stream *st, struct dx_server *s)
{
    struct dx_stream_reader *reader = st->options.reader;

    if (!reader || !dx_stream_reader_attached(reader))
        return 0;
    return dx_presence_add(s->presence, dx_stream_reader_subsystems(reader), poke_reader, reader);
}

int dx_server_stream_new(struct dx_server_stream **out,
                         const struct dx_server_stream_options *options)
{
    struct dx_server_stream *st = calloc(1, sizeof(*st));
    int r;

    if (!st)
        return -ENOMEM;
    st->options = *options;
    r = dx_feed_loop_new(&st->loop, options->feed);
    if (r < 0) {
        free(st);
        return r;
    }
    *out = st;
    return 0;
}

void dx_server_stream_free(struct dx_server_stream *st)
{
    if (!st)
        return;
    assert(!st->wake);
    dx_feed_loop_free(st->loop);
    free(st);
}

int dx_server_attach_stream(struct dx_server *s, struct dx_server_stream *st)
{
    int r;

    st->server = s;
    r = sd_event_add_io(s->event, &st->wake, st->options.feed->wake_fd, EPOLLIN, on_feed, st);
    if (r >= 0)
        r = sd_event_source_set_priority(st->wake, PRIORITY_FEED);
    if (r >= 0)
        r = watch_device(st, s);
    if (r < 0)
        dx_server_detach_stream(st);
    return r < 0 ? r : 0;
}

void dx_server_detach_stream(struct dx_server_stream *st)
{
    if (st->options.reader)
        dx_presence_remove(st->server->presence, st->options.reader);
    st->wake = sd_event_source_disable_unref(st->wake);
}

/* Where the stream of this name is, or would be: behind the last. */
static struct dx_server_stream **place_of(struct dx_server *s, const char *name)
{
    struct dx_server_stream **at = &s->streams;

    while (*at && strcmp((*at)->options.name, name))
        at = &(*at)->next;
    return at;
}

/* A subscriber that is closed on the way is freed later, by reap(). */
static void move_subscribers(struct dx_server_stream *from, struct dx_server_stream *to,
                             const char *reason)
{
    for (struct dx_subscriber *sub = from->server->subscribers; sub; sub = sub->next) {
        if (sub->stream != from)
            continue;
        dx_subscriber_move(sub, to, reason);
        dx_subscriber_pump(sub);
    }
}

struct dx_server_stream *dx_server_put_stream(struct dx_server *s, struct dx_server_stream *st,
                                              const char *reason)
{
    struct dx_server_stream **at = place_of(s, st->options.name), *before = *at;

    *at = st;
    if (!before) {
        st->number = s->next_number++;
        s->n_streams++;
        return NULL;
    }
    st->next = before->next;
    st->number = before->number;
    move_subscribers(before, st, reason);
    dx_server_detach_stream(before);
    return before;
}

struct dx_server_stream *dx_server_take_stream(struct dx_server *s, const char *name,
                                               const char *reason)
{
    struct dx_server_stream **at = place_of(s, name), *st = *at;

    if (!st)
        return NULL;
    *at = st->next;
    s->n_streams--;
    for (struct dx_subscriber *sub = s->subscribers; sub; sub = sub->next)
        if (sub->stream == st)
            dx_subscriber_shut(sub, DX_WIRE_E_NO_STREAM, reason, true);
    dx_server_detach_stream(st);
    return st;
}

int dx_server_add_stream(struct dx_server *s, const struct dx_server_stream_options *options)
{
    struct dx_server_stream *st;
    int r;

    if (*place_of(s, options->name))
        return -EEXIST;
    r = dx_server_stream_new(&st, options);
    if (r < 0)
        return r;
    r = dx_server_attach_stream(s, st);
    if (r < 0)
        dx_server_stream_free(st);
    else
        dx_server_put_stream(s, st, "");
    return r;
}

void dx_server_free_streams(struct dx_server *s)
{
    while (s->streams) {
        struct dx_server_stream *st = s->streams;

        s->streams = st->next;
        dx_server_detach_stream(st);
        dx_server_stream_free(st);
    }
}

/* ---- after events, and once a second ---------------------------------------------------------
 */

void dx_server_settle_streams(struct dx_server *s)
{
    for (struct dx_server_stream *st = s->streams; st; st = st->next)
        if (dx_feed_loop_settle(st->loop))
            wake_again(st);
}

static void sample_rates(struct dx_server_stream *st, uint64_t now)
{
    uint64_t n = dx_get(&st->options.counters->n_frames);

    if (st->rate_ns)
        st->frames_per_s = (double)(n - st->rate_frames) * 1e9 / (double)(now - st->rate_ns);
    st->rate_ns = now;
    st->rate_frames = n;
}

void dx_server_tick_streams(struct dx_server *s, uint64_t now_ns)
{
    for (struct dx_server_stream *st = s->streams; st; st = st->next) {
        dx_feed_loop_expire(st->loop, now_ns);
        sample_rates(st, now_ns);
    }
}
