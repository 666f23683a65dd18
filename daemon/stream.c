/* Streams: putting a source together and taking it apart, in reverse order. */
#include "daemon/stream.h"

#include "daemon/clock.h"
#include "daemon/log.h"
#include "daemon/mailbox.h"
#include "daemon/mesher.h"
#include "daemon/reader.h"

#include <errno.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* A grid may have so many tiles (4096 cells each); a feed of this size is address space, not
 * memory. */
#define MAX_TILES   16384
#define FEED_EPOCHS 6 /* one current, one being built, four pinned */

struct dx_stream {
    const struct dx_stream_config *config;
    struct dx_counters counters;
    struct dx_mailbox *mailbox;
    struct dx_feed *feed;
    struct dx_mesher *mesher;
    struct dx_stream_reader *reader;
    sem_t reader_done;
    sem_t start; /* raised when enough have subscribed, or at the stop */
    atomic_bool enough;
    bool reader_runs, mesher_runs;
    pthread_t reader_thread, mesher_thread;
};

static void kick_mesher(void *stream)
{
    struct dx_stream *s = stream;

    dx_mesher_kick(s->mesher);
}

int dx_stream_new(struct dx_stream **out, const struct dx_stream_config *config,
                  struct dx_pool *pool, struct dx_err *err)
{
    struct dx_mesher_config mesher = {.name = config->name,
                                      .terrain = config->mesh,
                                      .commit_ms = config->commit_ms,
                                      .lossless = config->lossless,
                                      .max_tiles = MAX_TILES};
    struct dx_stream *s = calloc(1, sizeof(*s));
    int r;

    if (!s)
        return dx_err_set(err, -ENOMEM, "stream %s: no memory", config->name);
    s->config = config;
    sem_init(&s->start, 0, 0);
    sem_init(&s->reader_done, 0, 0);
    r = dx_mailbox_new(&s->mailbox, config->lossless, kick_mesher, s);
    if (r == 0)
        r = dx_feed_new(&s->feed, MAX_TILES, FEED_EPOCHS, 2, -1, kick_mesher, s);
    if (r == 0)
        r = dx_mesher_new(&s->mesher, &mesher, s->mailbox, s->feed, &s->counters, pool);
    if (r < 0) {
        dx_err_set(err, r, "stream %s: %s", config->name, strerror(-r));
        goto err_stream;
    }
    r = dx_stream_reader_new(&s->reader, config->name, dx_driver_find(config->driver),
                             &config->source, s->mailbox, &s->counters, err);
    if (r < 0)
        goto err_stream;
    *out = s;
    return 0;

err_stream:
    dx_stream_free(s);
    return r;
}

void dx_stream_free(struct dx_stream *s)
{
    if (!s)
        return;
    dx_stream_reader_free(s->reader);
    dx_mesher_free(s->mesher);
    dx_feed_free(s->feed);
    dx_mailbox_free(s->mailbox);
    sem_destroy(&s->reader_done);
    sem_destroy(&s->start);
    free(s);
}

static void *reader_main(void *stream)
{
    struct dx_stream *s = stream;

    if (s->config->wait)
        dx_clock_sem_wait(&s->start, 0);
    dx_stream_reader_run(s->reader);
    sem_post(&s->reader_done);
    return NULL;
}

static void *mesher_main(void *stream)
{
    struct dx_stream *s = stream;

    dx_mesher_run(s->mesher);
    return NULL;
}

int dx_stream_start(struct dx_stream *s, struct dx_err *err)
{
    int r = pthread_create(&s->mesher_thread, NULL, mesher_main, s);

    s->mesher_runs = r == 0;
    if (r == 0)
        r = pthread_create(&s->reader_thread, NULL, reader_main, s);
    s->reader_runs = r == 0;
    if (r)
        return dx_err_set(err, -r, "stream %s: no thread: %s", s->config->name, strerror(r));
    pthread_setname_np(s->mesher_thread, "mesher");
    pthread_setname_np(s->reader_thread, "reader");
    return 0;
}

void dx_stream_stop(struct dx_stream *s)
{
    dx_mailbox_close(s->mailbox);
    if (s->reader_runs)
        dx_stream_reader_stop(s->reader);
    sem_post(&s->start);
    if (s->mesher_runs)
        dx_mesher_stop(s->mesher);
}

bool dx_stream_join(struct dx_stream *s, uint64_t due_ns)
{
    if (s->mesher_runs)
        pthread_join(s->mesher_thread, NULL);
    s->mesher_runs = false;
    if (s->reader_runs) {
        if (dx_clock_sem_wait(&s->reader_done, due_ns) < 0)
            return false;
        pthread_join(s->reader_thread, NULL); /* at once */
    }
    s->reader_runs = false;
    return true;
}

void dx_stream_subscribers(void *stream, uint32_t n)
{
    struct dx_stream *s = stream;

    if (s->config->wait && n >= s->config->wait &&
        !atomic_exchange_explicit(&s->enough, true, memory_order_relaxed))
        sem_post(&s->start);
}

struct dx_feed *dx_stream_feed(struct dx_stream *s)
{
    return s->feed;
}

struct dx_counters *dx_stream_counters(struct dx_stream *s)
{
    return &s->counters;
}

const struct dx_stream_config *dx_stream_config(const struct dx_stream *s)
{
    return s->config;
}
