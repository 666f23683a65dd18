/* The replay of recordings. `lock` guards what the loop thread asks for and is told. */
#include "daemon/player.h"

#include "daemon/config.h"
#include "daemon/log.h"
#include "drivers/file/playlist.h"
#include "drivers/monotonic.h"
#include "drivers/replay.h"

#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct dx_device {
    char name[128]; /* of the source, without folders */
    bool loop, restamp;
    uint64_t start, end; /* log times of what is played; end UINT64_MAX: all that comes */
    struct dx_playlist *list;
    struct dx_pace pace;

    /* the driver that recorded */
    struct dx_config recorded;
    const struct dx_driver *driver;
    struct dx_device *decoder;
    struct dx_geometry *adopt; /* before the next block; NULL: nothing */
    uint8_t adopt_attr_bytes;
    bool fresh; /* the decoder has seen no block */

    struct dx_playlist_block next;
    bool next_ready;
    uint64_t n_decoded, n_decoded_before; /* at the start of this pass */

    /* frame numbers: the recording's, and ours */
    struct dx_frame_sink sink; /* behind ours */
    bool any_frame, jumped;
    uint64_t frame_in, frame_out;

    pthread_mutex_t lock;
    struct dx_player_status status;
    uint64_t n_steps; /* frames to go though paused */
    bool wants_seek;
    double seek_s;
    bool new_rate;
};

static void player_close(struct dx_device *dev)
{
    if (!dev)
        return;
    if (dev->driver)
        dev->driver->close(dev->decoder);
    dx_config_fini(&dev->recorded);
    dx_geometry_unref(dev->adopt);
    dx_playlist_free(dev->list);
    dx_pace_fini(&dev->pace);
    pthread_mutex_destroy(&dev->lock);
    free(dev);
}

/* The recording's own configuration makes the decoder. */
static int open_decoder(struct dx_device *dev, struct dx_err *err)
{
    size_t len;
    const char *text = dx_playlist_config(dev->list, &len);
    int rc = dx_config_parse(&dev->recorded, DX_RECORDING_CONFIG_NAME, text, len, err);

    if (rc == 0 && dev->recorded.n_streams != 1)
        rc = dx_err_set(err, -EBADMSG, "%s of %u streams, expected one", DX_RECORDING_CONFIG,
                        dev->recorded.n_streams);
    if (rc == 0) {
        dev->driver = dx_driver_find(dev->recorded.streams[0].driver);
        rc = dev->driver->open_decoder(&dev->decoder, &dev->recorded.streams[0].source, err);
    }
    if (rc)
        dx_err_prefix(err, dev->name);
    return rc;
}

/* A time of the recording, `seconds` from its start; at most its end. */
static uint64_t log_time_at(const struct dx_device *dev, double seconds)
{
    uint64_t start = dx_playlist_start(dev->list), end = dx_playlist_end(dev->list);

    return seconds * 1e9 >= (double)(end - start) ? end : start + (uint64_t)(seconds * 1e9);
}

static int set_stretch(struct dx_device *dev, const struct dx_file_config *c, struct dx_err *err)
{
    double length_s = (double)(dx_playlist_end(dev->list) - dx_playlist_start(dev->list)) * 1e-9;

    if (c->start_s > length_s)
        return dx_err_set(err, -EINVAL, "%s: start is %g s, and the recording has %.3f s", c->path,
                          c->start_s, length_s);
    dev->start = log_time_at(dev, c->start_s);
    dev->end = c->end_s > 0 && c->end_s < length_s ? log_time_at(dev, c->end_s) : UINT64_MAX;
    dev->wants_seek = c->start_s > 0;
    dev->seek_s = c->start_s;
    return 0;
}

static void tell(const char *text)
{
    dx_log_warning("replay", "%s", text);
}

static int player_open(struct dx_device **out, const void *config, struct dx_err *err)
{
    const struct dx_file_config *c = config;
    struct dx_device *dev = calloc(1, sizeof(*dev));
    const char *slash = strrchr(c->path, '/');
    int rc;

    if (!dev)
        return dx_err_set(err, -ENOMEM, "%s: no memory", c->path);
    snprintf(dev->name, sizeof(dev->name), "%s", slash && slash[1] ? slash + 1 : c->path);
    dev->loop = c->loop;
    dev->restamp = c->restamp;
    pthread_mutex_init(&dev->lock, NULL);
    rc = dx_pace_init(&dev->pace, c->rate);
    if (rc)
        dx_err_set(err, rc, "%s: cannot set up pacing: %s", c->path, strerror(-rc));
    else
        rc = dx_playlist_new(&dev->list, c->path, tell, err);
    if (rc == 0)
        rc = set_stretch(dev, c, err);
    if (rc == 0)
        rc = open_decoder(dev, err);
    if (rc) {
        player_close(dev);
        return rc;
    }
    dev->fresh = true;
    dev->status.rate = c->rate;
    dev->status.length_s =
        (double)(dx_playlist_end(dev->list) - dx_playlist_start(dev->list)) * 1e-9;
    *out = dev;
    return 0;
}

static int player_start(struct dx_device *dev, struct dx_err *err)
{
    (void)err;
    dx_pace_restart(&dev->pace);
    return 0;
}

static void player_stop(struct dx_device *dev)
{
    pthread_mutex_lock(&dev->lock);
    dev->status.ended = true;
    pthread_mutex_unlock(&dev->lock);
}

/* ---- read ------------------------------------------------------------------------------------
 */

/* The decoder goes on with blocks that do not follow those it has seen. */
static void set_geometry(struct dx_device *dev, uint64_t time)
{
    dx_geometry_unref(dev->adopt);
    dev->adopt = NULL;
    if (dev->driver->adopt)
        (void)dx_playlist_geometry(dev->list, time, &dev->adopt, &dev->adopt_attr_bytes);
}

static int go_to(struct dx_device *dev, uint64_t time, struct dx_err *err)
{
    int rc = dx_playlist_seek(dev->list, time, err);

    dev->next_ready = false;
    dev->jumped = true;
    dx_pace_restart(&dev->pace);
    return rc;
}

/* Where a seek goes: within the stretch that is played. */
static uint64_t seek_time(const struct dx_device *dev)
{
    uint64_t time = log_time_at(dev, dev->seek_s);

    if (time < dev->start)
        return dev->start;
    return time < dev->end ? time : dev->end;
}

/* What was asked for since the last time. 0; AGAIN: nothing to play now; negative. */
static int obey(struct dx_device *dev, bool *idle, struct dx_err *err)
{
    uint64_t time = 0;
    bool seeks, rate;

    pthread_mutex_lock(&dev->lock);
    seeks = dev->wants_seek;
    rate = dev->new_rate;
    if (seeks) {
        time = seek_time(dev);
        dev->status.position_s = (double)(time - dx_playlist_start(dev->list)) * 1e-9;
    }
    dev->wants_seek = dev->new_rate = false;
    dev->pace.rate = dev->status.rate;
    *idle = dev->status.paused && dev->n_steps == 0;
    pthread_mutex_unlock(&dev->lock);
    if (rate || *idle)
        dx_pace_restart(&dev->pace);
    return seeks ? go_to(dev, time, err) : 0;
}

static int next_block(struct dx_device *dev, struct dx_err *err)
{
    int rc = dx_playlist_next(dev->list, &dev->next, err);

    return rc == 0 && dev->next.log_time > dev->end ? DX_DRIVER_E_EOF : rc;
}

/* The next block, over the end where it loops. */
static int fetch(struct dx_device *dev, struct dx_err *err)
{
    int rc = next_block(dev, err);

    /* a whole pass without a frame would be followed by the same for ever */
    if (rc == DX_DRIVER_E_EOF && dev->loop && dev->n_decoded != dev->n_decoded_before) {
        dev->n_decoded_before = dev->n_decoded;
        rc = go_to(dev, dev->start, err);
        if (rc == 0)
            rc = next_block(dev, err);
    }
    if (rc)
        return rc;
    /* the first block of a device makes its own geometry, as it did then */
    if ((dev->fresh || dev->jumped) && dev->next.block.number != 0)
        set_geometry(dev, dev->next.log_time);
    dev->next.block.first |= dev->jumped;
    dev->fresh = false;
    dev->next_ready = true;
    return 0;
}

static int player_read(struct dx_device *dev, struct dx_block *block, struct dx_err *err)
{
    bool idle;
    int rc = obey(dev, &idle, err);

    if (rc == 0 && idle)
        rc = dx_pace_idle(&dev->pace);
    if (rc == 0 && !dev->next_ready)
        rc = fetch(dev, err);
    if (rc == 0)
        rc = dx_pace_wait(&dev->pace, dev->next.log_time);
    if (rc)
        return rc;
    dev->next_ready = false;
    *block = dev->next.block;
    block->stamp.host_ns = dx_clock_ns();
    pthread_mutex_lock(&dev->lock);
    dev->status.position_s = (double)(dev->next.log_time - dx_playlist_start(dev->list)) * 1e-9;
    pthread_mutex_unlock(&dev->lock);
    return 0;
}

/* ---- decode ----------------------------------------------------------------------------------
 */

static int on_geometry(void *player, struct dx_geometry *g, uint8_t attr_bytes)
{
    struct dx_device *dev = player;

    return dev->sink.geometry(dev->sink.ctx, g, attr_bytes);
}

static struct dx_plane *on_plane(void *player, uint64_t number)
{
    struct dx_device *dev = player;

    if (!dev->any_frame)
        dev->frame_out = number;
    else if (dev->jumped || number < dev->frame_in)
        dev->frame_out++;
    else
        dev->frame_out += number - dev->frame_in;
    dev->any_frame = true;
    dev->jumped = false;
    dev->frame_in = number;
    return dev->sink.plane(dev->sink.ctx, dev->frame_out);
}

static void on_deliver(void *player, const struct dx_frame_part *part)
{
    struct dx_device *dev = player;
    struct dx_frame_part ours = *part;

    ours.frame = dev->frame_out;
    if (dev->restamp) {
        ours.stamp.device_ns = ours.stamp.host_ns;
        ours.stamp.clock_id = DX_CLOCK_MONOTONIC;
    } else if (ours.stamp.clock_id == DX_CLOCK_NONE) {
        ours.stamp.device_ns = dev->next.log_time;
        ours.stamp.clock_id = DX_CLOCK_REALTIME;
    }
    dev->sink.deliver(dev->sink.ctx, &ours);
    if (!part->last)
        return;
    pthread_mutex_lock(&dev->lock);
    dev->status.n_frames++;
    dev->n_steps -= dev->n_steps > 0;
    pthread_mutex_unlock(&dev->lock);
}

static int player_decode(struct dx_device *dev, const struct dx_block *block,
                         const struct dx_frame_sink *sink, struct dx_err *err)
{
    const struct dx_frame_sink ours = {dev, on_geometry, on_plane, on_deliver};
    int rc = 0;

    dev->sink = *sink;
    if (dev->adopt) {
        rc = dev->driver->adopt(dev->decoder, dev->adopt, dev->adopt_attr_bytes, &ours, err);
        dx_geometry_unref(dev->adopt);
        dev->adopt = NULL;
    }
    if (rc == 0)
        rc = dev->driver->decode(dev->decoder, block, &ours, err);
    dev->n_decoded += rc == 0;
    return rc;
}

/* ---- the rest --------------------------------------------------------------------------------
 */

static void player_wake(struct dx_device *dev)
{
    dx_pace_wake(&dev->pace);
}

static void player_describe(struct dx_device *dev, char *text, size_t len)
{
    size_t n_files = dx_playlist_n_files(dev->list);
    int n = snprintf(text, len, "%s: recording of '%s', %zu file%s; ", dev->name,
                     dev->recorded.streams[0].name, n_files, n_files == 1 ? "" : "s");

    if (n >= 0 && (size_t)n < len)
        dev->driver->describe(dev->decoder, text + n, len - (size_t)n);
}

const struct dx_driver dx_player_driver = {
    .name = "file",
    .open = player_open,
    .open_decoder = player_open,
    .start = player_start,
    .read = player_read,
    .read_s = 600,
    .decode = player_decode,
    .stop = player_stop,
    .close = player_close,
    .wake = player_wake,
    .describe = player_describe,
};

const char *dx_player_config_text(const struct dx_device *dev, size_t *len)
{
    return dx_playlist_config(dev->list, len);
}

const char *dx_player_driver_name(const struct dx_device *dev)
{
    return dev->driver->name;
}

/* ---- any thread ------------------------------------------------------------------------------
 */

void dx_player_pause(struct dx_device *dev, bool paused)
{
    pthread_mutex_lock(&dev->lock);
    dev->status.paused = paused;
    dev->n_steps = 0;
    pthread_mutex_unlock(&dev->lock);
    dx_pace_wake(&dev->pace);
}

void dx_player_step(struct dx_device *dev, uint64_t n_frames)
{
    pthread_mutex_lock(&dev->lock);
    dev->n_steps = dev->status.paused ? dev->n_steps + n_frames : n_frames;
    dev->status.paused = true;
    pthread_mutex_unlock(&dev->lock);
    dx_pace_wake(&dev->pace);
}

void dx_player_seek(struct dx_device *dev, double seconds)
{
    pthread_mutex_lock(&dev->lock);
    dev->wants_seek = true;
    dev->seek_s = seconds > 0 ? seconds : 0;
    pthread_mutex_unlock(&dev->lock);
    dx_pace_wake(&dev->pace);
}

void dx_player_rate(struct dx_device *dev, double rate)
{
    pthread_mutex_lock(&dev->lock);
    dev->status.rate = rate;
    dev->new_rate = true;
    pthread_mutex_unlock(&dev->lock);
    dx_pace_wake(&dev->pace);
}

void dx_player_status(struct dx_device *dev, struct dx_player_status *out)
{
    pthread_mutex_lock(&dev->lock);
    *out = dev->status;
    pthread_mutex_unlock(&dev->lock);
}
