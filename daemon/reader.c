/* The reader thread. */
#include "daemon/reader.h"

#include "daemon/log.h"

#include <errno.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>

struct dx_stream_reader {
    const char *name;
    const struct dx_driver *driver;
    struct dx_device *device;
    struct dx_mailbox *mailbox;
    struct dx_counters *counters;
    struct dx_recorder *recorder; /* NULL: none */
    struct dx_frame_sink sink;    /* the mailbox's, behind ours */
    bool frame_ended;             /* by the last part delivered; at the start: yes */
    atomic_bool stop;
    bool is_live;       /* a frame has come, and subscribers know */
    struct dx_err last; /* what was wrong with the newest block that was wrong */
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
    result = driver->open(&r->device, driver_config, err);
    if (result < 0) {
        free(r);
        return result;
    }
    *out = r;
    return 0;
}

void dx_stream_reader_free(struct dx_stream_reader *r)
{
    if (!r)
        return;
    r->driver->close(r->device);
    free(r);
}

void dx_stream_reader_record(struct dx_stream_reader *r, struct dx_recorder *recorder)
{
    r->recorder = recorder;
}

struct dx_device *dx_stream_reader_device(struct dx_stream_reader *r)
{
    return r->device;
}

void dx_stream_reader_stop(struct dx_stream_reader *r)
{
    atomic_store_explicit(&r->stop, true, memory_order_release);
    r->driver->wake(r->device);
}

static bool stopped(struct dx_stream_reader *r)
{
    return atomic_load_explicit(&r->stop, memory_order_acquire);
}

/* ---- between driver and mailbox: what a recording must know ----------------------------------
 */

static int on_geometry(void *reader, struct dx_geometry *g, uint8_t attr_bytes)
{
    struct dx_stream_reader *r = reader;

    if (r->recorder)
        dx_recorder_geometry(r->recorder, g, attr_bytes);
    return r->sink.geometry(r->sink.ctx, g, attr_bytes);
}

static struct dx_plane *on_plane(void *reader, uint64_t number)
{
    struct dx_stream_reader *r = reader;

    return r->sink.plane(r->sink.ctx, number);
}

static void on_deliver(void *reader, const struct dx_frame_part *part)
{
    struct dx_stream_reader *r = reader;

    r->frame_ended = part->last;
    r->sink.deliver(r->sink.ctx, part);
}

/* ---- the loop --------------------------------------------------------------------------------
 */

static void decode(struct dx_stream_reader *r, const struct dx_block *block)
{
    const struct dx_frame_sink sink = {r, on_geometry, on_plane, on_deliver};
    struct dx_err err = {""};
    int result = r->driver->decode(r->device, block, &sink, &err);

    if (result == 0) {
        if (!r->is_live)
            dx_mailbox_put_state(r->mailbox, DX_STREAM_LIVE, "");
        r->is_live = true;
    } else if (result != DX_DRIVER_E_AGAIN && !stopped(r)) { /* a closed mailbox is no damage */
        dx_count(&r->counters->n_corrupt, 1);
        dx_log_warning("reader", "%s: %s", r->name, err.text);
        r->last = err;
    }
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

void dx_stream_reader_run(struct dx_stream_reader *r)
{
    struct dx_err err = {""};
    int result = r->driver->start(r->device, &err);

    while (result >= 0 && !stopped(r)) {
        struct dx_block block;

        result = r->driver->read(r->device, &block, &err);
        if (result == 0) {
            bool starts_frame = r->frame_ended;

            decode(r, &block);
            if (r->recorder) /* after the mesher has it: the mesh does not wait for the copy */
                dx_recorder_feed(r->recorder, &block, starts_frame);
        } else if (result != DX_DRIVER_E_AGAIN) {
            break;
        }
    }
    if (!stopped(r))
        finish(r, result, &err);
    r->driver->stop(r->device);
}
