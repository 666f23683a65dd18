/* The reader thread. */
#include "daemon/reader.h"

#include "daemon/clock.h"
#include "daemon/fault.h"
#include "daemon/log.h"

#include <errno.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>

#define SECOND_NS 1000000000u

struct dx_stream_reader {
    const char *name;
    const struct dx_driver *driver;
    struct dx_device *device;          /* a source; of a driver of devices, what decodes */
    struct dx_reader_device *attached; /* NULL: the source is no device */
    bool is_remote;                    /* it is one on the network */
    struct dx_geometry *told;          /* of a device: by the decoder, last */
    uint8_t told_attr_bytes;
    struct dx_mailbox *mailbox;
    struct dx_counters *counters;
    struct dx_recorder *recorder; /* NULL: none */
    struct dx_frame_sink sink;    /* the mailbox's, behind ours */
    bool frame_ended;             /* by the last part delivered; at the start: yes */
    atomic_bool stop;
    struct dx_heartbeat *beat;  /* NULL: nobody watches */
    uint64_t grid_ns, block_ns; /* what a decode may take: by the size of the grid, of the block */
    bool any_part;              /* of a frame has come since it was not live */
    bool is_live;               /* ... and subscribers know */
    struct dx_err last;         /* what was wrong with the newest block that was wrong */
};

int dx_stream_reader_new(struct dx_stream_reader **out, const char *name,
                         const struct dx_driver *driver, const void *driver_config,
                         struct dx_mailbox *mailbox, struct dx_counters *counters,
                         struct dx_err *err)
{
    struct dx_stream_reader *r = calloc(1, sizeof(*r));
    int result;

    if (!r)
        return dx_err_set(err, -ENOMEM, "no memory");
    r->name = name;
    r->driver = driver;
    r->mailbox = mailbox;
    r->counters = counters;
    r->sink = dx_mailbox_sink(mailbox);
    r->frame_ended = true;
    r->is_remote = driver->is_remote && driver->is_remote(driver_config);
    if (driver->subsystems) {
        result = driver->open_decoder(&r->device, driver_config, err);
        if (result >= 0)
            result = dx_reader_device_new(&r->attached, name, driver, driver_config, mailbox, err);
    } else {
        result = driver->open(&r->device, driver_config, err);
    }
    if (result < 0) {
        dx_stream_reader_free(r);
        return result;
    }
    *out = r;
    return 0;
}

void dx_stream_reader_free(struct dx_stream_reader *r)
{
    if (!r)
        return;
    dx_reader_device_free(r->attached);
    r->driver->close(r->device);
    dx_geometry_unref(r->told);
    free(r);
}

void dx_stream_reader_record(struct dx_stream_reader *r, struct dx_recorder *recorder)
{
    r->recorder = recorder;
}

void dx_stream_reader_watch(struct dx_stream_reader *r, struct dx_heartbeat *beat)
{
    r->beat = beat;
    if (r->attached)
        dx_reader_device_watch(r->attached, beat);
}

struct dx_device *dx_stream_reader_device(struct dx_stream_reader *r)
{
    return r->device;
}

struct dx_reader_device *dx_stream_reader_attached(struct dx_stream_reader *r)
{
    return r->attached;
}

const char *const *dx_stream_reader_subsystems(const struct dx_stream_reader *r)
{
    static const char *const none[] = {NULL};

    return r->is_remote ? none : r->driver->subsystems;
}

void dx_stream_reader_stop(struct dx_stream_reader *r)
{
    atomic_store_explicit(&r->stop, true, memory_order_release);
    if (r->attached)
        dx_reader_device_wake(r->attached);
    else
        r->driver->wake(r->device);
}

static bool stopped(struct dx_stream_reader *r)
{
    return atomic_load_explicit(&r->stop, memory_order_acquire);
}

/* ---- between driver and mailbox: what a recording must know ----------------------------------
 */

/* A device that is back tells its geometry again: for subscribers nothing has changed. */
static bool is_told(struct dx_stream_reader *r, struct dx_geometry *g, uint8_t attr_bytes)
{
    if (!r->attached)
        return false;
    if (r->told && r->told_attr_bytes == attr_bytes && dx_geometry_is_same(r->told, g))
        return true;
    dx_geometry_unref(r->told);
    r->told = dx_geometry_ref(g);
    r->told_attr_bytes = attr_bytes;
    return false;
}

static void beat_for_decode(struct dx_stream_reader *r)
{
    dx_heartbeat_allow(r->beat, dx_clock_ns(), r->grid_ns + r->block_ns);
}

static int on_geometry(void *reader, struct dx_geometry *g, uint8_t attr_bytes)
{
    struct dx_stream_reader *r = reader;
    int result;

    r->grid_ns = (uint64_t)g->height * g->width * DX_HEARTBEAT_DEXEL_NS;
    beat_for_decode(r);
    if (is_told(r, g, attr_bytes))
        return 0;
    if (r->recorder)
        dx_recorder_geometry(r->recorder, g, attr_bytes);
    dx_heartbeat_rest(r->beat); /* for the mesher, which has a heartbeat of its own */
    result = r->sink.geometry(r->sink.ctx, g, attr_bytes);
    beat_for_decode(r);
    return result;
}

static struct dx_plane *on_plane(void *reader, uint64_t number)
{
    struct dx_stream_reader *r = reader;
    struct dx_plane *plane;

    dx_heartbeat_rest(r->beat); /* lossless, for the mesher and its subscribers */
    plane = r->sink.plane(r->sink.ctx, number);
    beat_for_decode(r);
    return plane;
}

static void on_deliver(void *reader, const struct dx_frame_part *part)
{
    struct dx_stream_reader *r = reader;

    r->frame_ended = part->last;
    r->any_part = true;
    r->sink.deliver(r->sink.ctx, part);
}

/* ---- the loop --------------------------------------------------------------------------------
 */

static void complain(struct dx_stream_reader *r, const struct dx_err *err)
{
    dx_count(&r->counters->n_corrupt, 1);
    r->last = *err;
    if (r->attached) /* which may go on so for days */
        dx_reader_device_log(r->attached, LOG_WARNING, err->text);
    else
        dx_log_warning("reader", "%s: %s", r->name, err->text);
}

static void decode(struct dx_stream_reader *r, const struct dx_block *block)
{
    const struct dx_frame_sink sink = {r, on_geometry, on_plane, on_deliver};
    struct dx_err err = {""};
    int result;

    r->block_ns = block->len * DX_HEARTBEAT_BYTE_NS;
    beat_for_decode(r);
    dx_fault_point(DX_FAULT_READER);
    result = r->driver->decode(r->device, block, &sink, &err);

    if (r->any_part && !r->is_live) {
        dx_mailbox_put_state(r->mailbox, DX_STREAM_LIVE, "");
        r->is_live = true;
    }
    if (result != 0 && result != DX_DRIVER_E_AGAIN &&
        !stopped(r)) /* a closed mailbox is no damage */
        complain(r, &err);
}

/* What subscribers are told when the source is over: that nothing more will come, and why when that
 * is a fault. A replay that had no good frame is one. */
static void finish(struct dx_stream_reader *r, int result, const struct dx_err *err)
{
    char text[512];

    if (result == DX_DRIVER_E_EOF && (r->is_live || !r->last.text[0])) {
        r->driver->describe(r->device, text, sizeof(text));
        dx_log_info("reader", "%s: ended: %s", r->name, text);
        dx_mailbox_put_state(r->mailbox, DX_STREAM_ENDED, "");
        return;
    }
    if (result == DX_DRIVER_E_EOF)
        err = &r->last;
    dx_log_error("reader", "%s: ended: %s", r->name, err->text);
    dx_mailbox_put_state(r->mailbox, DX_STREAM_ENDED, err->text);
}

static int read_block(struct dx_stream_reader *r, struct dx_block *block, struct dx_err *err)
{
    int result;

    dx_heartbeat_allow(r->beat, dx_clock_ns(), (uint64_t)r->driver->read_s * SECOND_NS);
    if (!r->attached)
        return r->driver->read(r->device, block, err);
    result = dx_reader_device_read(r->attached, block);
    if (!dx_reader_device_streams(r->attached))
        r->is_live = r->any_part = false;
    if (result == 0 && block->first)
        r->frame_ended = true; /* what the last stay left half done is void */
    return result;
}

static int take_blocks(struct dx_stream_reader *r, struct dx_err *err)
{
    int result = 0;

    while ((result == 0 || result == DX_DRIVER_E_AGAIN) && !stopped(r)) {
        bool starts_frame = r->frame_ended;
        struct dx_block block;

        result = read_block(r, &block, err);
        if (result != 0)
            continue;
        decode(r, &block);
        if (r->recorder) /* after the mesher has it: the mesh does not wait for the copy */
            dx_recorder_feed(r->recorder, &block, starts_frame);
    }
    return result;
}

/* A device: its stays, until it is stopped. */
static void run_device(struct dx_stream_reader *r)
{
    struct dx_err err = {""};

    take_blocks(r, &err);
    dx_reader_device_close(r->attached);
}

/* A source, to its end. */
static void run_source(struct dx_stream_reader *r)
{
    struct dx_err err = {""};
    int result = r->driver->start(r->device, &err);

    if (result >= 0)
        result = take_blocks(r, &err);
    if (!stopped(r))
        finish(r, result, &err);
    r->driver->stop(r->device);
}

void dx_stream_reader_run(struct dx_stream_reader *r)
{
    dx_heartbeat_beat(r->beat, dx_clock_ns());
    if (r->attached)
        run_device(r);
    else
        run_source(r);
    dx_heartbeat_rest(r->beat);
}
