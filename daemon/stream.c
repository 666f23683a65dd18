/* Streams: putting a source together and taking it apart, in reverse order. */
#include "daemon/stream.h"

#include "daemon/clock.h"
#include "daemon/fault.h"
#include "daemon/heartbeat.h"
#include "daemon/log.h"
#include "daemon/mailbox.h"
#include "daemon/mesher.h"
#include "daemon/player.h"
#include "drivers/file/playlist.h"
#include "daemon/reader.h"
#include "daemon/record_files.h"

#include <errno.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define RECORDER_NS 2000000000u /* for the recorder to end its file */
#define FEED_EPOCHS 6           /* one current, one being built, four pinned */

struct dx_stream {
    struct dx_stream_config *config; /* its own copy */
    struct dx_counters counters;
    struct dx_heartbeats beats;
    struct dx_mailbox *mailbox;
    struct dx_feed *feed;
    struct dx_mesher *mesher;
    struct dx_stream_reader *reader;
    struct dx_rig *rig; /* GPIO lines; NULL: none */
    bool replays;       /* recordings: the device is a player */
    struct dx_record_files files;
    struct dx_recorder *recorder; /* NULL: none */
    sem_t reader_done, recorder_done;
    sem_t start; /* raised when enough have subscribed, or at the stop */
    atomic_bool enough;
    bool reader_runs, mesher_runs, recorder_runs;
    pthread_t reader_thread, mesher_thread, recorder_thread;
};

static void kick_mesher(void *stream)
{
    struct dx_stream *s = stream;

    dx_mesher_kick(s->mesher);
}

/* ---- recording -------------------------------------------------------------------------------
 */

static int create_file(void *ctx, struct dx_mcap_sink *sink, const char **path, uint64_t unix_ns)
{
    struct dx_record_files *f = ctx;
    int r = dx_record_files_create(f, unix_ns);

    *path = f->path;
    if (r == 0)
        *sink = dx_mcap_sink_fd(f->fd);
    return r;
}

static int sync_file(void *ctx)
{
    dx_record_files_trim(ctx);
    return dx_record_files_sync(ctx);
}

static void close_file(void *ctx)
{
    dx_record_files_close(ctx);
}

/* What decodes the blocks: of a replay, what the recording says. */
static int make_recorder(struct dx_stream *s, struct dx_recorder_config *c, struct dx_err *err)
{
    struct dx_device *player = dx_stream_player(s);
    char *text = NULL;
    int r = 0;

    if (player) {
        c->driver = dx_player_driver_name(player);
        c->yaml = dx_player_config_text(player, &c->yaml_len);
    } else {
        r = dx_config_stream_text(&text, &c->yaml_len, s->config);
        c->yaml = text;
    }
    if (r == 0)
        r = dx_recorder_new(&s->recorder, c, err);
    else
        dx_err_set(err, r, "%s", strerror(-r));
    free(text);
    return r;
}

static int open_recorder(struct dx_stream *s, struct dx_err *err)
{
    const struct dx_record_config *record = &s->config->record;
    struct dx_recorder_config c = {
        .name = s->config->name,
        .driver = s->config->driver,
        .store = {&s->files, create_file, sync_file, close_file},
        .ring_len = (size_t)record->buffer_mib << 20,
        .compression = (enum dx_mcap_compression)record->compression,
        .split_len = (uint64_t)record->split_mib << 20,
        .split_ns = (uint64_t)record->split_s * 1000000000u,
        .start = record->start,
        .beat = &s->beats.of[DX_BEAT_RECORDER],
    };
    int r;

    if (!*record->path)
        return 0;
    dx_record_files_init(&s->files, record->path, (uint64_t)record->keep_mib << 20);
    r = make_recorder(s, &c, err);
    if (r)
        return r;
    dx_stream_reader_record(s->reader, s->recorder);
    return 0;
}

/* ---- the stream ------------------------------------------------------------------------------
 */

static int open_reader(struct dx_stream *s, struct dx_err *err)
{
    const struct dx_stream_config *c = s->config;
    const struct dx_driver *driver = dx_driver_find(c->driver);
    int r;

    if (driver == &dx_file_driver) {
        const struct dx_file_config *file = &c->source.file;

        s->replays = dx_playlist_wants(file->path);
        if (!s->replays && (file->start_s > 0 || file->end_s > 0 || file->restamp))
            return dx_err_set(err, -EINVAL,
                              "%s: no recording, and start, end and stamps are of those",
                              file->path);
    }
    r = dx_stream_reader_new(&s->reader, c->name, s->replays ? &dx_player_driver : driver,
                             &c->source, s->mailbox, &s->counters, err);
    if (r == 0)
        dx_stream_reader_watch(s->reader, &s->beats.of[DX_BEAT_READER]);
    return r;
}

/* The reader is there. */
static int open_rig(struct dx_stream *s, struct dx_err *err)
{
    struct dx_reader_device *device = dx_stream_reader_attached(s->reader);
    int r;

    if (!device || !dx_rig_is_wanted(&s->config->gpio))
        return 0;
    r = dx_rig_open(&s->rig, &s->config->gpio, err);
    if (r == 0)
        dx_reader_device_rig(device, s->rig);
    return r;
}

int dx_stream_new(struct dx_stream **out, const struct dx_stream_config *config,
                  struct dx_pool *pool, struct dx_err *err)
{
    struct dx_mesher_config mesher = {.terrain = config->mesh,
                                      .commit_ms = config->commit_ms,
                                      .lossless = config->lossless,
                                      .max_tiles = dx_stream_max_tiles};
    struct dx_stream *s = calloc(1, sizeof(*s));
    struct dx_log_about was;
    int r;

    if (!s || dx_config_stream_copy(&s->config, config) < 0) {
        free(s);
        return dx_err_set(err, -ENOMEM, "%s", strerror(ENOMEM));
    }
    mesher.name = s->config->name;
    sem_init(&s->start, 0, 0);
    sem_init(&s->reader_done, 0, 0);
    sem_init(&s->recorder_done, 0, 0);
    r = dx_mailbox_new(&s->mailbox, config->lossless, kick_mesher, s);
    if (r == 0)
        r = dx_feed_new(&s->feed, dx_stream_max_tiles, FEED_EPOCHS, 2, -1, kick_mesher, s);
    mesher.beat = &s->beats.of[DX_BEAT_MESHER];
    if (r == 0)
        r = dx_mesher_new(&s->mesher, &mesher, s->mailbox, s->feed, &s->counters, pool);
    if (r < 0) {
        dx_err_set(err, r, "%s", strerror(-r));
        goto err_stream;
    }
    was = dx_log_about((struct dx_log_about){.stream = config->name});
    dx_fault_point(DX_FAULT_OPEN);
    r = open_reader(s, err);
    if (r == 0)
        r = open_rig(s, err);
    if (r == 0)
        r = open_recorder(s, err);
    dx_log_about(was);
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
    dx_rig_close(s->rig);
    dx_recorder_free(s->recorder);
    dx_mesher_free(s->mesher);
    dx_feed_free(s->feed);
    dx_mailbox_free(s->mailbox);
    sem_destroy(&s->reader_done);
    sem_destroy(&s->recorder_done);
    sem_destroy(&s->start);
    dx_config_stream_free(s->config);
    free(s);
}

static void *reader_main(void *stream)
{
    struct dx_stream *s = stream;

    dx_log_about((struct dx_log_about){.stream = s->config->name});
    if (s->config->wait)
        dx_clock_sem_wait(&s->start, 0);
    dx_stream_reader_run(s->reader);
    sem_post(&s->reader_done);
    return NULL;
}

static void *mesher_main(void *stream)
{
    struct dx_stream *s = stream;

    dx_log_about((struct dx_log_about){.stream = s->config->name});
    dx_mesher_run(s->mesher);
    return NULL;
}

static void *recorder_main(void *stream)
{
    struct dx_stream *s = stream;

    dx_log_about((struct dx_log_about){.stream = s->config->name});
    dx_recorder_run(s->recorder);
    sem_post(&s->recorder_done);
    return NULL;
}

/* What never ran: told by whoever is in the place of the thread that would. */
static int tell_no_thread(struct dx_stream *s, int error, struct dx_err *err)
{
    char text[DX_WIRE_TEXT];

    snprintf(text, sizeof(text), "no thread: %s", strerror(error));
    if (s->mesher_runs)
        dx_mailbox_put_state(s->mailbox, DX_STREAM_GONE, text);
    else
        dx_feed_state(s->feed, DX_STREAM_GONE, text);
    return dx_err_set(err, -error, "stream %s: %s", s->config->name, text);
}

int dx_stream_start(struct dx_stream *s, struct dx_err *err)
{
    int r = s->recorder ? pthread_create(&s->recorder_thread, NULL, recorder_main, s) : 0;

    s->recorder_runs = s->recorder && r == 0;
    if (r == 0)
        r = pthread_create(&s->mesher_thread, NULL, mesher_main, s);
    s->mesher_runs = r == 0;
    if (r == 0)
        r = pthread_create(&s->reader_thread, NULL, reader_main, s);
    s->reader_runs = r == 0;
    if (r)
        return tell_no_thread(s, r, err);
    pthread_setname_np(s->mesher_thread, "mesher");
    pthread_setname_np(s->reader_thread, "reader");
    if (s->recorder_runs)
        pthread_setname_np(s->recorder_thread, "recorder");
    return 0;
}

bool dx_stream_is_started(const struct dx_stream *s)
{
    return s->mesher_runs && s->reader_runs;
}

void dx_stream_stop(struct dx_stream *s)
{
    if (s->rig) /* the laser goes off whether the reader comes back or not */
        dx_rig_end(s->rig);
    dx_mailbox_close(s->mailbox);
    if (s->reader_runs)
        dx_stream_reader_stop(s->reader);
    sem_post(&s->start);
    if (s->mesher_runs)
        dx_mesher_stop(s->mesher);
}

static bool join_reader(struct dx_stream *s, uint64_t due_ns)
{
    if (!s->reader_runs)
        return true;
    if (dx_clock_sem_wait(&s->reader_done, due_ns) < 0)
        return false;
    pthread_join(s->reader_thread, NULL); /* at once */
    s->reader_runs = false;
    return true;
}

/* It finishes its file, if the disk lets it. */
static bool join_recorder(struct dx_stream *s, bool reader_is_back)
{
    if (!s->recorder_runs)
        return true;
    dx_recorder_stop(s->recorder, reader_is_back);
    if (dx_clock_sem_wait(&s->recorder_done, dx_clock_ns() + RECORDER_NS) < 0)
        return false;
    pthread_join(s->recorder_thread, NULL);
    s->recorder_runs = false;
    return true;
}

bool dx_stream_join(struct dx_stream *s, uint64_t due_ns)
{
    bool reader_is_back;

    if (s->mesher_runs)
        pthread_join(s->mesher_thread, NULL);
    s->mesher_runs = false;
    reader_is_back = join_reader(s, due_ns);
    return join_recorder(s, reader_is_back) && reader_is_back;
}

struct dx_recorder *dx_stream_recorder(struct dx_stream *s)
{
    return s->recorder;
}

struct dx_device *dx_stream_player(struct dx_stream *s)
{
    return s->replays ? dx_stream_reader_device(s->reader) : NULL;
}

struct dx_stream_reader *dx_stream_reader(struct dx_stream *s)
{
    return s->reader;
}

void dx_stream_subscribers(void *stream, uint32_t n)
{
    struct dx_stream *s = stream;

    if (s->config->wait && n >= s->config->wait &&
        !atomic_exchange_explicit(&s->enough, true, memory_order_relaxed))
        sem_post(&s->start);
}

const struct dx_heartbeats *dx_stream_beats(const struct dx_stream *s)
{
    return &s->beats;
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
