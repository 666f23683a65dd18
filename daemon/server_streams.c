/*
 * The streams of a server: each has a feed, whose loop half is here, and the subscribers that are
 * on it. Loop thread.
 */
#include "daemon/server_priv.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <unistd.h>

#include "daemon/reader.h"

#define PRIORITY_FEED -10 /* adoption first: it frees chunks for the mesher */

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

static int watch_device(struct dx_server *s, struct dx_stream_reader *reader)
{
    if (!reader || !dx_stream_reader_attached(reader))
        return 0;
    return dx_presence_add(s->presence, dx_stream_reader_subsystems(reader), poke_reader, reader);
}

int dx_server_add_stream(struct dx_server *s, const struct dx_server_stream_options *options)
{
    struct dx_server_stream *st, **end = &s->streams;
    int r;

    for (; *end; end = &(*end)->next)
        if (!strcmp((*end)->options.name, options->name))
            return -EEXIST;
    st = calloc(1, sizeof(*st));
    if (!st)
        return -ENOMEM;
    st->server = s;
    st->options = *options;
    st->number = s->n_streams;
    r = dx_feed_loop_new(&st->loop, options->feed);
    if (r == 0)
        r = watch_device(s, options->reader);
    if (r == 0)
        r = sd_event_add_io(s->event, &st->wake, options->feed->wake_fd, EPOLLIN, on_feed, st);
    if (r < 0) {
        dx_feed_loop_free(st->loop);
        free(st);
        return r;
    }
    sd_event_source_set_priority(st->wake, PRIORITY_FEED);
    *end = st;
    s->n_streams++;
    return 0;
}

static void free_stream(struct dx_server_stream *st)
{
    sd_event_source_disable_unref(st->wake);
    dx_feed_loop_free(st->loop);
    free(st);
}

void dx_server_free_streams(struct dx_server *s)
{
    while (s->streams) {
        struct dx_server_stream *next = s->streams->next;

        free_stream(s->streams);
        s->streams = next;
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
