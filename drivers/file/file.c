/*
 * The file driver. read() takes the files in turn and cuts them into blocks of one frame; decode()
 * makes points of a block and ranges of the points. What cannot be read becomes an empty block, so
 * that it is reported by decode() as damaged and the next file still comes.
 */
#include "drivers/file/file.h"

#include "drivers/file/array.h"
#include "drivers/file/cloud_bag.h"
#include "drivers/file/file_list.h"
#include "drivers/file/format.h"
#include "drivers/file/slurp.h"
#include "drivers/monotonic.h"
#include "drivers/replay.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define DEFAULT_FPS 10.0
#define NO_FORMAT   "neither PTX nor PCD nor MCAP (a cloud without an order is for dexel mesh --mode)"

struct dx_device {
    struct dx_file_config config; /* without its texts */
    char *topic;                  /* of clouds in MCAP files */
    char name[128];               /* of the source, without folders */
    struct dx_file_list list;
    struct dx_pace pace;

    /* read(): the open file and the next block of it */
    size_t next_file;
    bool file_open, block_ready;
    struct dx_slurp file;
    struct dx_cloud_bag *bag; /* NULL: the file is `file` */
    size_t offset;            /* of the next block */
    unsigned scans;           /* blocks cut from this file */
    uint64_t number, n_decoded;
    uint64_t decoded_before; /* n_decoded at the start of this pass over the files */
    struct dx_block block;
    struct dx_err fault; /* why `block` is empty */
    char source[PATH_MAX + 32];

    /* decode() */
    struct dx_xyz_frame frame;
    struct dx_array array;
};

static int check_config(const struct dx_file_config *c, struct dx_err *err)
{
    int rc;

    if (!c->path || !c->path[0])
        return dx_err_set(err, -EINVAL, "file: no path, expected a file, directory or glob");
    if (!(c->rate >= 0) || isinf(c->rate))
        return dx_err_set(err, -EINVAL, "file: rate %g, expected 0 (max) or more", c->rate);
    if (!(c->fps >= 0) || c->fps > 1e6)
        return dx_err_set(err, -EINVAL, "file: fps %g, expected 0 (default) to 1e6", c->fps);
    if (c->attr_bytes < -1 || c->attr_bytes > 2)
        return dx_err_set(err, -EINVAL, "file: attr_bytes %d, expected -1 to 2", c->attr_bytes);
    rc = dx_array_check(&c->thin, c->exact, err);
    if (rc)
        dx_err_prefix(err, "file");
    return rc;
}

static void file_close(struct dx_device *dev)
{
    if (!dev)
        return;
    dx_pace_fini(&dev->pace);
    dx_file_list_fini(&dev->list);
    dx_slurp_fini(&dev->file);
    dx_cloud_bag_close(dev->bag);
    free(dev->topic);
    dx_xyz_frame_fini(&dev->frame);
    dx_array_fini(&dev->array);
    free(dev);
}

static void set_name(struct dx_device *dev, const char *path)
{
    const char *slash = strrchr(path, '/');

    snprintf(dev->name, sizeof(dev->name), "%s", slash && slash[1] ? slash + 1 : path);
}

/* All but the files. */
static int open_decoder(struct dx_device **out, const void *config, struct dx_err *err)
{
    const struct dx_file_config *c = config;
    struct dx_device *dev;
    int rc = check_config(c, err);

    if (rc)
        return rc;
    dev = calloc(1, sizeof(*dev));
    if (!dev)
        return dx_err_set(err, -ENOMEM, "%s: no memory", c->path);
    dev->config = *c;
    dev->array.fit = c->fit;
    dev->array.thin = c->thin;
    dev->array.exact = c->exact;
    dev->config.fps = c->fps > 0 ? c->fps : DEFAULT_FPS;
    set_name(dev, c->path);
    rc = dx_pace_init(&dev->pace, c->rate);
    dev->config.path = dev->config.topic = NULL; /* the caller's memory */
    dev->topic = strdup(c->topic ? c->topic : "");
    if (rc == 0 && !dev->topic)
        rc = -ENOMEM;
    if (rc) {
        file_close(dev);
        return dx_err_set(err, rc, "%s: cannot be opened: %s", c->path, strerror(-rc));
    }
    *out = dev;
    return 0;
}

/* A source of which no file can be a recording was not meant: it is refused before anything else is
 * given up for it. */
static int check_files(const struct dx_file_list *list, struct dx_err *err)
{
    for (size_t k = 0; k < list->n; k++)
        if (dx_format_may_be(list->paths[k]))
            return 0;
    return dx_err_set(err, -EBADMSG, "%s: " NO_FORMAT, list->paths[0]);
}

static int file_open(struct dx_device **out, const void *config, struct dx_err *err)
{
    const struct dx_file_config *c = config;
    struct dx_device *dev = NULL;
    int rc = open_decoder(&dev, config, err);

    if (rc)
        return rc;
    rc = dx_file_list_init(&dev->list, c->path, err);
    if (rc == 0)
        rc = check_files(&dev->list, err);
    if (rc) {
        file_close(dev);
        return rc;
    }
    *out = dev;
    return 0;
}

static int file_start(struct dx_device *dev, struct dx_err *err)
{
    (void)err;
    dx_pace_restart(&dev->pace);
    return 0;
}

static void file_stop(struct dx_device *dev)
{
    (void)dev;
}

/* ---- read ------------------------------------------------------------------------------------ */

static void set_block(struct dx_device *dev, const uint8_t *bytes, size_t len)
{
    const char *path = dev->list.paths[dev->next_file - 1];

    if (dev->scans++ == 0)
        snprintf(dev->source, sizeof(dev->source), "%s", path);
    else
        snprintf(dev->source, sizeof(dev->source), "scan %u of %s", dev->scans, path);
    dev->block = (struct dx_block){
        .bytes = len ? bytes : NULL,
        .len = len,
        .number = dev->number++,
        .source = dev->source,
    };
    dev->block.stamp.device_ns = (uint64_t)((double)dev->block.number / dev->config.fps * 1e9);
    dev->block.stamp.clock_id = DX_CLOCK_NONE;
    dev->block_ready = true;
}

/* The file that was opened last cannot be used: an empty block stands for it. */
static void set_fault(struct dx_device *dev)
{
    dev->file_open = false;
    set_block(dev, NULL, 0);
}

static int open_file(struct dx_device *dev, const char *path)
{
    dx_cloud_bag_close(dev->bag);
    dev->bag = NULL;
    if (!dx_cloud_bag_probe(path))
        return dx_slurp_file(&dev->file, path, DX_SLURP_MAX, &dev->fault);
    dx_pace_restart(&dev->pace); /* its times are its own */
    return dx_cloud_bag_open(&dev->bag, path, dev->topic,
                             dev->config.any_order ? DX_MCAP_FILE_ORDER : DX_MCAP_LOG_TIME,
                             &dev->fault);
}

/* Opens the next file; a block is ready only when it could not be read. EOF at the end. */
static int open_next(struct dx_device *dev)
{
    const char *path;

    if (dev->next_file == dev->list.n) {
        /* a whole pass without a frame: looping would report the same errors for ever */
        if (!dev->config.loop || dev->n_decoded == dev->decoded_before)
            return DX_DRIVER_E_EOF;
        dev->next_file = 0;
    }
    if (dev->next_file == 0)
        dev->decoded_before = dev->n_decoded;
    path = dev->list.paths[dev->next_file++];
    dev->offset = 0;
    dev->scans = 0;
    dev->file_open = true;
    if (open_file(dev, path) != 0)
        set_fault(dev);
    return 0;
}

/* Cuts the next block from the open file, or closes it. */
static void cut(struct dx_device *dev)
{
    const uint8_t *bytes = dev->file.bytes + dev->offset;
    size_t left = dev->file.len - dev->offset;
    const char *path = dev->list.paths[dev->next_file - 1];
    const struct dx_format *format = left ? dx_format_find(bytes, left, path) : NULL;
    int64_t len = format ? format->block_len(bytes, left, NULL) : 0;

    if (len != 0) {
        /* with an error in it, the rest: decode() will say what is wrong */
        set_block(dev, bytes, len > 0 ? (size_t)len : left);
        dev->offset += dev->block.len;
    } else if (dev->offset == 0) {
        dx_err_set(&dev->fault, 0, "%s: %s", path,
                   left && !format ? NO_FORMAT : "empty, expected a recording");
        set_fault(dev);
    } else {
        dev->file_open = false;
    }
}

/* The next message of the open file is a block, at its own time. */
static void take_message(struct dx_device *dev)
{
    struct dx_mcap_message m;
    int rc = dx_cloud_bag_next(dev->bag, &m, &dev->fault);

    if (rc < 0) {
        set_fault(dev);
    } else if (rc == 0) {
        set_block(dev, m.data.p, m.data.len);
        dev->block.stamp.device_ns = m.log_time;
        dev->block.stamp.clock_id = DX_CLOCK_REALTIME;
    } else if (dev->scans == 0) {
        dx_err_set(&dev->fault, 0, "%s: found no message, expected clouds",
                   dev->list.paths[dev->next_file - 1]);
        set_fault(dev);
    } else {
        dev->file_open = false;
    }
}

static int file_read(struct dx_device *dev, struct dx_block *block, struct dx_err *err)
{
    int rc = 0;

    while (!dev->block_ready && rc == 0) {
        if (dev->file_open && dev->bag)
            take_message(dev);
        else if (dev->file_open)
            cut(dev);
        else
            rc = open_next(dev);
    }
    if (rc)
        return rc;
    rc = dx_pace_wait(&dev->pace, dev->block.stamp.device_ns);
    if (rc)
        return rc > 0 ? rc : dx_err_set(err, rc, "%s: wait: %s", dev->name, strerror(-rc));
    dev->block_ready = false;
    *block = dev->block;
    block->stamp.host_ns = dx_clock_ns();
    return 0;
}

/* ---- decode ---------------------------------------------------------------------------------- */

static int read_points(struct dx_device *dev, const struct dx_block *block, struct dx_err *err)
{
    const struct dx_format *format;
    int rc;

    if (block->len == 0)
        return dx_err_set(err, DX_DRIVER_E_CORRUPT, "%s",
                          dev->fault.text[0] ? dev->fault.text : "empty block");
    format = dx_format_find(block->bytes, block->len, block->source);
    if (!format)
        return dx_err_set(err, DX_DRIVER_E_CORRUPT, "%s: " NO_FORMAT, block->source);
    rc = format->decode(&dev->frame, block->bytes, block->len, err);
    if (rc)
        dx_err_prefix(err, block->source);
    return rc == 0 || rc == -ENOMEM ? rc : DX_DRIVER_E_CORRUPT;
}

/* The attribute in the depth that planes will have. */
static struct dx_points to_points(struct dx_device *dev)
{
    struct dx_xyz_frame *f = &dev->frame;
    size_t n = (size_t)f->height * f->width;
    uint8_t depth = f->attr ? f->attr_bytes : 0;
    uint8_t want = dev->config.attr_bytes < 0 ? depth : (uint8_t)dev->config.attr_bytes;

    if (depth == 2 && want == 1)
        for (size_t k = 0; k < n; k++)
            f->attr[k] = (uint16_t)(f->attr[k] >> 8);
    if (depth == 1 && want == 2)
        for (size_t k = 0; k < n; k++)
            f->attr[k] = (uint16_t)(f->attr[k] * 257);
    return (struct dx_points){f->height, f->width, f->xyz, want ? f->attr : NULL, want};
}

static int file_decode(struct dx_device *dev, const struct dx_block *block,
                       const struct dx_frame_sink *sink, struct dx_err *err)
{
    struct dx_frame_part part = {.frame = block->number, .last = true, .stamp = block->stamp};
    struct dx_points points;
    struct dx_plane *plane;
    int rc = read_points(dev, block, err);

    if (rc)
        return rc;
    points = to_points(dev);
    rc = dx_array_settle(&dev->array, &points, dev->frame.pose, block->source, sink, err);
    if (rc)
        return rc;
    plane = sink->plane(sink->ctx, block->number);
    if (!plane)
        return DX_DRIVER_E_AGAIN;
    dx_array_fill(&dev->array, plane, &points);
    part.n_cols = dev->array.geometry->width;
    dev->n_decoded++;
    sink->deliver(sink->ctx, &part);
    return 0;
}

static int file_adopt(struct dx_device *dev, struct dx_geometry *g, uint8_t attr_bytes,
                      const struct dx_frame_sink *sink, struct dx_err *err)
{
    (void)err;
    return dx_array_adopt(&dev->array, g, attr_bytes, sink);
}

/* ---- the rest -------------------------------------------------------------------------------- */

static void file_wake(struct dx_device *dev)
{
    dx_pace_wake(&dev->pace);
}

static void file_describe(struct dx_device *dev, char *text, size_t len)
{
    const struct dx_geometry *g = dev->array.geometry;
    int n =
        snprintf(text, len, "%s: %zu file%s", dev->name, dev->list.n, dev->list.n == 1 ? "" : "s");

    if (!g || n < 0 || (size_t)n >= len)
        return;
    snprintf(text + n, len - (size_t)n,
             ", %s %ux%u, rms %.2g dexel, regularity %.2g dexel, unit %g mm",
             dx_model_name(g->model), g->width, g->height, dev->array.report.rms_dexel,
             dev->array.report.regularity, (double)g->unit_m * 1000);
}

const struct dx_fit_report *dx_file_fit_report(const struct dx_device *dev)
{
    return dev->array.geometry ? &dev->array.report : NULL;
}

const struct dx_driver dx_file_driver = {
    .name = "file",
    .open = file_open,
    .open_decoder = open_decoder,
    .start = file_start,
    .read = file_read,
    .read_s = 600,
    .decode = file_decode,
    .adopt = file_adopt,
    .stop = file_stop,
    .close = file_close,
    .wake = file_wake,
    .describe = file_describe,
};
