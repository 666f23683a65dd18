/*
 * A driver of a device that exists in the test's head: it appears, vanishes, falls silent, fails
 * and comes back with another geometry as the test says, from its own thread. Frames are two blocks
 * of half a frame each. One such device at a time.
 */
#ifndef FAKE_DRIVER_H
#define FAKE_DRIVER_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "core/base/bytes.h"
#include "drivers/driver.h"

#include <errno.h>
#include <poll.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <time.h>
#include <unistd.h>

#define FAKE_ROWS       8
#define FAKE_COLS       16
#define FAKE_BLOCK_LEN  16
#define FAKE_SILENCE_NS 200000000u

/* What the test says; all of it at any time. */
struct fake_world {
    _Atomic bool present;
    _Atomic bool silent;
    _Atomic bool distant;               /* it is not reached */
    _Atomic bool spoils;                /* silent: what comes is damaged */
    _Atomic int open_error, read_error; /* negative: that */
    _Atomic uint32_t variant;           /* of the geometry */
    _Atomic unsigned serial;
    _Atomic unsigned n_opens, n_open; /* so far; now */
    _Atomic int fd;                   /* of the open one, to hurry it */
};

static struct fake_world fake;

struct dx_device {
    int fd;
    uint64_t n_blocks, n_damaged;
    uint8_t bytes[FAKE_BLOCK_LEN];

    /* the decoder's */
    struct dx_geometry *geometry;
    uint32_t variant;
    uint64_t frame;
    unsigned half; /* of the frame under way that has come */
};

static inline int fake_new(struct dx_device **out)
{
    struct dx_device *dev = calloc(1, sizeof(*dev));

    assert_non_null(dev);
    dev->fd = -1;
    *out = dev;
    return 0;
}

static int fake_open(struct dx_device **out, const void *config, struct dx_err *err)
{
    (void)config;
    if (!fake.present)
        return dx_err_set(err, DX_DRIVER_E_GONE, "no fake is attached");
    if (fake.open_error)
        return dx_err_set(err, fake.open_error, "fake: %s", strerror(-fake.open_error));
    fake_new(out);
    (*out)->fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    assert_true((*out)->fd >= 0);
    fake.fd = (*out)->fd;
    fake.n_opens++;
    fake.n_open++;
    return 0;
}

static int fake_open_decoder(struct dx_device **out, const void *config, struct dx_err *err)
{
    (void)config;
    (void)err;
    return fake_new(out);
}

static int fake_connect(struct dx_device *dev, struct dx_err *err)
{
    struct pollfd p = {dev->fd, POLLIN, 0};
    uint64_t n;

    if (!fake.distant)
        return 0;
    if (!fake.present)
        return dx_err_set(err, DX_DRIVER_E_GONE, "no fake is attached");
    if (poll(&p, 1, 50) > 0)
        assert_int_equal(read(dev->fd, &n, sizeof(n)), sizeof(n));
    return DX_DRIVER_E_AGAIN;
}

static int fake_start(struct dx_device *dev, struct dx_err *err)
{
    (void)dev;
    (void)err;
    return 0;
}

/* A block each 2 ms. */
static int fake_read(struct dx_device *dev, struct dx_block *block, struct dx_err *err)
{
    struct pollfd p = {dev->fd, POLLIN, 0};
    uint64_t n;

    if (poll(&p, 1, fake.silent ? 50 : 2) > 0) {
        assert_int_equal(read(dev->fd, &n, sizeof(n)), sizeof(n));
        return DX_DRIVER_E_AGAIN;
    }
    if (!fake.present)
        return dx_err_set(err, DX_DRIVER_E_GONE, "the fake was unplugged");
    if (fake.read_error)
        return dx_err_set(err, fake.read_error, "fake: %s", strerror(-fake.read_error));
    if (fake.silent) {
        dev->n_damaged += fake.spoils;
        return DX_DRIVER_E_AGAIN;
    }
    dx_put_u32(dev->bytes, fake.variant);
    dx_put_u64(dev->bytes + 4, dev->n_blocks++);
    *block = (struct dx_block){.bytes = dev->bytes, .len = FAKE_BLOCK_LEN, .source = "fake"};
    return 0;
}

/* The geometry is told with each stay, though it is the same: who tells it on must see that. */
static inline int fake_tell(struct dx_device *dev, uint32_t variant,
                            const struct dx_frame_sink *sink)
{
    dx_geometry_unref(dev->geometry);
    dev->geometry = NULL;
    assert_int_equal(
        dx_geometry_new_pinhole(&dev->geometry, FAKE_ROWS, FAKE_COLS, 10.0 + variant, 10, 8, 4), 0);
    dev->variant = variant;
    return sink->geometry(sink->ctx, dev->geometry, 0);
}

static int fake_decode(struct dx_device *dev, const struct dx_block *block,
                       const struct dx_frame_sink *sink, struct dx_err *err)
{
    struct dx_frame_part part = {.n_cols = FAKE_COLS / 2};
    uint32_t variant;
    struct dx_plane *plane;

    if (block->len != FAKE_BLOCK_LEN)
        return dx_err_set(err, DX_DRIVER_E_CORRUPT, "fake: block %llu of %zu bytes, expected %d",
                          (unsigned long long)block->number, block->len, FAKE_BLOCK_LEN);
    variant = dx_get_u32(block->bytes);
    if (block->first && dev->half) {
        dev->half = 0; /* what has come of the frame is void */
        dev->frame++;
    }
    if (!dev->geometry || block->first || variant != dev->variant)
        if (fake_tell(dev, variant, sink) != 0)
            return DX_DRIVER_E_AGAIN;
    part.frame = dev->frame;
    plane = sink->plane(sink->ctx, dev->frame);
    if (!plane)
        return DX_DRIVER_E_AGAIN;
    part.col0 = dev->half * part.n_cols;
    for (uint32_t row = 0; row < FAKE_ROWS; row++)
        for (uint32_t col = part.col0; col < part.col0 + part.n_cols; col++)
            ((uint16_t *)plane->range)[row * plane->width + col] = 1000;
    part.last = dev->half == 1;
    dev->half = !dev->half;
    dev->frame += part.last;
    sink->deliver(sink->ctx, &part);
    return 0;
}

static void fake_stop(struct dx_device *dev)
{
    (void)dev;
}

static void fake_close(struct dx_device *dev)
{
    if (!dev)
        return;
    if (dev->fd >= 0) {
        close(dev->fd);
        fake.n_open--;
    }
    dx_geometry_unref(dev->geometry);
    free(dev);
}

static void fake_wake(struct dx_device *dev)
{
    uint64_t one = 1;

    assert_int_equal(write(dev->fd, &one, sizeof(one)), sizeof(one));
}

static uint64_t fake_silence_ns(const struct dx_device *dev)
{
    (void)dev;
    return FAKE_SILENCE_NS;
}

static void fake_health(const struct dx_device *dev, struct dx_device_health *out)
{
    snprintf(out->serial, sizeof(out->serial), "F%u", fake.serial);
    snprintf(out->place, sizeof(out->place), "nowhere");
    out->n_lost = dev->n_blocks ? 3 : 0;
    out->n_damaged = dev->n_damaged;
}

static void fake_describe(struct dx_device *dev, char *text, size_t len)
{
    (void)dev;
    snprintf(text, len, "fake");
}

static const char *const fake_subsystems[] = {"fake", NULL};

static const struct dx_driver fake_driver = {
    .name = "fake",
    .subsystems = fake_subsystems,
    .open = fake_open,
    .open_decoder = fake_open_decoder,
    .connect = fake_connect,
    .start = fake_start,
    .read = fake_read,
    .decode = fake_decode,
    .stop = fake_stop,
    .close = fake_close,
    .wake = fake_wake,
    .silence_ns = fake_silence_ns,
    .health = fake_health,
    .describe = fake_describe,
};

#endif
