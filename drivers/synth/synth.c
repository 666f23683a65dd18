/*
 * The synthetic driver. A raw block is 16 bytes: frame number (8), first column of the part (4),
 * hash of the configuration (4). The noise-free sights of a frame are kept from frame to frame, and
 * only what has moved is looked at anew, so a frame costs its noise. Owned by the reader thread;
 * wake() from any.
 */
#include "drivers/synth/synth.h"

#include "core/base/bytes.h"
#include "core/base/hash.h"
#include "drivers/monotonic.h"
#include "drivers/replay.h"
#include "drivers/synth/sight.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define BLOCK_LEN 16

struct dx_device {
    struct dx_synth_config config;
    uint32_t config_hash;
    struct dx_geometry *geometry;
    bool told; /* the sink knows the geometry */
    struct dx_pace pace;
    uint64_t frame; /* of the next block */
    uint32_t col;
    uint64_t n_blocks;
    uint8_t block[BLOCK_LEN];
    /* Sights of scene frame `sights_frame`: a column before and one after the grid's, for mixing.
     */
    struct dx_sight *sights;
    uint64_t sights_frame;
};

static uint32_t config_hash(const struct dx_synth_config *c)
{
    const struct dx_scene_config *s = &c->scene;
    const uint64_t words[] = {
        (uint64_t)s->scene,
        s->height,
        s->width,
        dx_f64_bits(s->sigma[0]),
        dx_f64_bits(s->sigma[1]),
        dx_f64_bits(s->sigma[2]),
        dx_f64_bits(s->dropout),
        dx_f64_bits(s->mixed),
        s->seed,
        dx_f64_bits(s->unit_m),
        s->attr_bytes,
        (uint64_t)s->flip_rows << 1 | s->flip_cols,
        dx_f64_bits(c->fps),
        c->n_frames,
        c->loop,
        c->part_cols,
    };
    uint64_t h = 0;

    for (size_t k = 0; k < sizeof(words) / sizeof(words[0]); k++)
        h = dx_hash_u64(h, words[k]);
    return (uint32_t)h;
}

static int check(const struct dx_synth_config *c, struct dx_err *err)
{
    const struct dx_scene_config *s = &c->scene;

    if (!(c->fps > 0 && c->fps <= 1e6))
        return dx_err_set(err, -EINVAL, "synthetic: fps is %g, expected 0 < fps <= 1e6", c->fps);
    if (!(c->rate >= 0))
        return dx_err_set(err, -EINVAL, "synthetic: rate is %g, expected 0 or more", c->rate);
    if (!(s->dropout >= 0 && s->dropout <= 1 && s->mixed >= 0 && s->mixed <= 1))
        return dx_err_set(err, -EINVAL, "synthetic: dropout is %g and mixed %g, expected 0..1",
                          s->dropout, s->mixed);
    for (int k = 0; k < 3; k++)
        if (!(s->sigma[k] >= 0 && s->sigma[k] <= 1))
            return dx_err_set(err, -EINVAL, "synthetic: sigma is %g,%g,%g, expected 0..1 each",
                              s->sigma[0], s->sigma[1], s->sigma[2]);
    return 0;
}

/* Row `row` of the sights; element 0 is the grid's column -1. */
static struct dx_sight *sights_row(const struct dx_device *dev, uint32_t row)
{
    return dev->sights + (size_t)row * (dev->geometry->width + 2);
}

static void look_all(struct dx_device *dev)
{
    const struct dx_geometry *g = dev->geometry;
    struct dx_world world;

    dx_world_init(&world, &dev->config.scene, 0);
    for (uint32_t row = 0; row < g->height; row++)
        dx_sight_row(sights_row(dev, row), &world, g, row, -1, g->width + 2);
    dev->sights_frame = 0;
}

static void look_rect(struct dx_device *dev, const struct dx_world *world, struct dx_rect rect)
{
    for (uint32_t row = rect.row0; row < rect.row1; row++)
        dx_sight_row(sights_row(dev, row) + 1 + rect.col0, world, dev->geometry, row, rect.col0,
                     rect.col1 - rect.col0);
}

/* Brings the sights to scene frame `number`: only where the moving shape was and is can they
 * differ. */
static void look_again(struct dx_device *dev, uint64_t number)
{
    struct dx_world before, now;

    if (dev->sights_frame == number || !dx_world_moves(dev->config.scene.scene))
        return;
    dx_world_init(&before, &dev->config.scene, dev->sights_frame);
    dx_world_init(&now, &dev->config.scene, number);
    look_rect(dev, &now, dx_world_moving_rect(dev->geometry, &before));
    look_rect(dev, &now, dx_world_moving_rect(dev->geometry, &now));
    dev->sights_frame = number;
}

static void synth_close(struct dx_device *dev)
{
    if (!dev)
        return;
    dx_pace_fini(&dev->pace);
    dx_geometry_unref(dev->geometry);
    free(dev->sights);
    free(dev);
}

static int synth_open(struct dx_device **out, const void *config, struct dx_err *err)
{
    const struct dx_synth_config *c = config;
    struct dx_device *dev;
    int r = check(c, err);

    if (r)
        return r;
    dev = calloc(1, sizeof(*dev));
    if (!dev)
        return dx_err_set(err, -ENOMEM, "synthetic: out of memory");
    dev->config = *c;
    dev->config_hash = config_hash(c);
    r = dx_pace_init(&dev->pace, c->rate);
    if (r) {
        free(dev);
        return dx_err_set(err, r, "synthetic: cannot set up pacing: %s", strerror(-r));
    }
    r = dx_scene_geometry(&dev->geometry, &c->scene);
    if (r) {
        dx_err_set(err, r, "synthetic: scene %u of %u rows x %u columns, unit %g m: %s",
                   (unsigned)c->scene.scene, c->scene.height, c->scene.width, c->scene.unit_m,
                   r == -ENOMEM ? "out of memory" : "not possible");
        goto err_device;
    }
    dev->sights = calloc(c->scene.height, (c->scene.width + 2) * sizeof(*dev->sights));
    if (!dev->sights) {
        r = dx_err_set(err, -ENOMEM, "synthetic: out of memory");
        goto err_device;
    }
    look_all(dev);
    *out = dev;
    return 0;

err_device:
    synth_close(dev);
    return r;
}

static int synth_start(struct dx_device *dev, struct dx_err *err)
{
    (void)err;
    dev->frame = 0;
    dev->col = 0;
    dev->n_blocks = 0;
    dev->told = false;
    dx_pace_restart(&dev->pace);
    return 0;
}

/* Columns of the part that starts at `col`. */
static uint32_t part_len(const struct dx_device *dev, uint32_t col)
{
    uint32_t left = dev->geometry->width - col, part = dev->config.part_cols;

    return part == 0 || part > left ? left : part;
}

static int synth_read(struct dx_device *dev, struct dx_block *block, struct dx_err *err)
{
    const struct dx_synth_config *c = &dev->config;
    double turned = (double)dev->col / dev->geometry->width;
    uint64_t stamp = (uint64_t)rint(((double)dev->frame + turned) / c->fps * 1e9);
    int r;

    if (c->n_frames && !c->loop && dev->frame >= c->n_frames)
        return DX_DRIVER_E_EOF;
    r = dx_pace_wait(&dev->pace, stamp);
    if (r < 0)
        dx_err_set(err, r, "synthetic: cannot wait for the next frame");
    if (r)
        return r;
    dx_put_u64(dev->block, dev->frame);
    dx_put_u32(dev->block + 8, dev->col);
    dx_put_u32(dev->block + 12, dev->config_hash);
    *block = (struct dx_block){
        .bytes = dev->block,
        .len = BLOCK_LEN,
        .stamp = {dx_clock_ns(), stamp, DX_CLOCK_DEVICE},
        .number = dev->n_blocks++,
        .source = dx_scene_name(c->scene.scene),
    };
    dev->col += part_len(dev, dev->col);
    if (dev->col == dev->geometry->width) {
        dev->col = 0;
        dev->frame++;
    }
    return 0;
}

/* Columns [col0, col0 + n) of scene frame `number`, as dx_scene_cast gives them. */
static void sense(struct dx_device *dev, struct dx_plane *plane, uint64_t number, uint32_t col0,
                  uint32_t n)
{
    uint32_t height = dev->geometry->height;
    struct dx_sensor sensor;

    look_again(dev, number);
    dx_sensor_init(&sensor, dev->geometry, &dev->config.scene, number);
    for (uint32_t row = 0; row < height; row++)
        dx_sensor_row(plane, &sensor, row, col0, n, sights_row(dev, row) + 1 + col0,
                      row > 0 ? sights_row(dev, row - 1) + 1 + col0 : NULL,
                      row + 1 < height ? sights_row(dev, row + 1) + 1 + col0 : NULL);
}

static int check_block(const struct dx_device *dev, const struct dx_block *block,
                       struct dx_err *err)
{
    if (block->len != BLOCK_LEN)
        return dx_err_set(err, DX_DRIVER_E_CORRUPT, "%s: block %llu: length is %zu, expected %d",
                          block->source, (unsigned long long)block->number, block->len, BLOCK_LEN);
    if (dx_get_u32(block->bytes + 12) != dev->config_hash)
        return dx_err_set(err, DX_DRIVER_E_CORRUPT,
                          "%s: block %llu: configuration hash is %08x, expected %08x",
                          block->source, (unsigned long long)block->number,
                          dx_get_u32(block->bytes + 12), dev->config_hash);
    if (dx_get_u32(block->bytes + 8) >= dev->geometry->width)
        return dx_err_set(err, DX_DRIVER_E_CORRUPT,
                          "%s: block %llu: first column is %u, expected less than %u",
                          block->source, (unsigned long long)block->number,
                          dx_get_u32(block->bytes + 8), dev->geometry->width);
    return 0;
}

static int synth_decode(struct dx_device *dev, const struct dx_block *block,
                        const struct dx_frame_sink *sink, struct dx_err *err)
{
    const struct dx_synth_config *c = &dev->config;
    struct dx_frame_part part = {.stamp = block->stamp};
    struct dx_plane *plane;
    uint64_t scene_frame;
    int r = check_block(dev, block, err);

    if (r)
        return r;
    if (!dev->told) {
        r = sink->geometry(sink->ctx, dev->geometry, c->scene.attr_bytes);
        if (r)
            return r;
        dev->told = true;
    }
    part.frame = dx_get_u64(block->bytes);
    part.col0 = dx_get_u32(block->bytes + 8);
    part.n_cols = part_len(dev, part.col0);
    part.last = part.col0 + part.n_cols == dev->geometry->width;
    plane = sink->plane(sink->ctx, part.frame);
    if (!plane)
        return DX_DRIVER_E_AGAIN;
    scene_frame = c->loop && c->n_frames ? part.frame % c->n_frames : part.frame;
    sense(dev, plane, scene_frame, part.col0, part.n_cols);
    sink->deliver(sink->ctx, &part);
    return 0;
}

static void synth_stop(struct dx_device *dev)
{
    (void)dev;
}

static void synth_wake(struct dx_device *dev)
{
    dx_pace_wake(&dev->pace);
}

static void synth_describe(struct dx_device *dev, char *text, size_t len)
{
    const struct dx_synth_config *c = &dev->config;

    snprintf(text, len, "%s: %s %ux%u, %g frames a second, noise %g m, drop-outs %g, mixed %g",
             dx_scene_name(c->scene.scene), dx_model_name(dev->geometry->model),
             dev->geometry->height, dev->geometry->width, c->fps, c->scene.sigma[0],
             c->scene.dropout, c->scene.mixed);
}

const struct dx_driver dx_synth_driver = {
    .name = "synthetic",
    .open = synth_open,
    .open_decoder = synth_open,
    .start = synth_start,
    .read = synth_read,
    .decode = synth_decode,
    .stop = synth_stop,
    .close = synth_close,
    .wake = synth_wake,
    .describe = synth_describe,
};
