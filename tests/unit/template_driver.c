/*
 * A driver of a device, to begin a new one from: an imaginary depth camera on a serial line. It is
 * complete and test_template_driver.c runs it; CONTRIBUTING.md tells what else belongs to a driver.
 * Copy it to drivers/NAME/, replace what is the imaginary camera's, and keep the comments that are
 * about your device only. All functions are called by the reader's thread, save wake() and probe().
 *
 * What the camera sends, little endian: "DF", columns u16, rows u16, number u32, then columns x
 * rows z-depths u16 in mm, 0 where there was no return. Begin yours with such a paragraph, its
 * source (protocol document and section) included.
 */
#include "core/base/bytes.h"
#include "drivers/driver.h"
#include "drivers/monotonic.h"
#include "drivers/udev.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <termios.h>
#include <unistd.h>

/* In drivers/NAME/NAME.h, with a member in the union of daemon/config.h and a row for each key in
 * daemon/config_rows_NAME.h. Constant while the service runs. */
struct dx_template_config {
    const char *node;
};

#define MAX_COLS   640
#define MAX_ROWS   480
#define FRAME_HEAD 10 /* of the camera's frame */
#define FRAME_LEN  (FRAME_HEAD + 2 * MAX_COLS * MAX_ROWS)
#define FOCAL      500.0 /* pixels */

/* The head of a block. A recording is decoded on another machine, without the camera: all that
 * decode() must know is here, in each block. */
#define BLOCK_MAGIC   0x4c504d54u /* "TMPL" */
#define BLOCK_VERSION 1
#define BLOCK_HEAD    12 /* magic u32, version u16, spare u16, mm of a count f32 */

#define PERIOD_NS     33000000u /* of the camera's frames */

struct dx_device {
    /* the device's half; a decoder has none of it, and fd -1 */
    int fd, wake_fd;
    char node[64];
    uint8_t *block; /* head, and the frame that comes in; allocated at the opening, never later */
    size_t len;     /* of the frame, so far */
    bool given;     /* it was whole, and the last read() handed it over */
    bool any;
    uint32_t number; /* of the last frame, the camera's */
    uint64_t n_lost, n_damaged;

    /* the decoder's half */
    struct dx_geometry *geometry; /* NULL: none told yet */
    uint64_t frame; /* the next one's number: upwards for as long as the stream lives */
};

/* ---- the device ------------------------------------------------------------------------------
 */

static void template_close(struct dx_device *dev)
{
    if (!dev)
        return;
    if (dev->fd >= 0)
        close(dev->fd);
    if (dev->wake_fd >= 0)
        close(dev->wake_fd);
    dx_geometry_unref(dev->geometry);
    free(dev->block);
    free(dev);
}

static int new_device(struct dx_device **out, struct dx_err *err)
{
    struct dx_device *dev = calloc(1, sizeof(*dev));

    if (!dev)
        return dx_err_set(err, -ENOMEM, "template: no memory");
    dev->fd = dev->wake_fd = -1;
    *out = dev;
    return 0;
}

/* Checks what of the configuration can be checked without the camera; touches nothing. */
static int template_open_decoder(struct dx_device **out, const void *config, struct dx_err *err)
{
    (void)config;
    return new_device(out, err);
}

/* GONE and a fault are different: the first waits for the device to come, the second is told as a
 * fault and tried again. A missing permission names node and rule (dx_udev_refused). */
static int open_node(struct dx_device *dev, struct dx_err *err)
{
    struct termios line;

    dev->fd = open(dev->node, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (dev->fd >= 0 && tcgetattr(dev->fd, &line) == 0) {
        cfmakeraw(&line);
        tcsetattr(dev->fd, TCSANOW, &line);
    }
    if (dev->fd >= 0)
        return 0;
    if (errno == ENOENT || errno == ENODEV || errno == ENXIO)
        return dx_err_set(err, DX_DRIVER_E_GONE, "template: no camera at %s", dev->node);
    return dx_udev_refused(err, -errno, dev->node);
}

static int template_open(struct dx_device **out, const void *config, struct dx_err *err)
{
    const struct dx_template_config *c = config;
    struct dx_device *dev = NULL;
    int r = new_device(&dev, err);

    if (r)
        return r;
    snprintf(dev->node, sizeof(dev->node), "%s", c->node);
    r = open_node(dev, err);
    if (r)
        goto err_device;
    dev->wake_fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    dev->block = malloc(BLOCK_HEAD + FRAME_LEN);
    if (dev->wake_fd < 0 || !dev->block) {
        r = dx_err_set(err, dev->block ? -errno : -ENOMEM, "template: %s: out of resources",
                       c->node);
        goto err_device;
    }
    dx_put_u32(dev->block, BLOCK_MAGIC);
    dx_put_u16(dev->block + 4, BLOCK_VERSION);
    dx_put_u16(dev->block + 6, 0);
    dx_put_u32(dev->block + 8, dx_f32_bits(1.0f));
    *out = dev;
    return 0;

err_device:
    template_close(dev);
    return r;
}

static int template_start(struct dx_device *dev, struct dx_err *err)
{
    if (write(dev->fd, "GO", 2) != 2)
        return dx_err_set(err, -EIO, "template: %s: it takes no command", dev->node);
    return 0;
}

/* ---- read: the device's bytes, as they are ---------------------------------------------------
 */

/* How long the frame must be that has begun; 0: this is no frame. */
static size_t frame_len(const uint8_t *f, size_t len)
{
    uint32_t cols, rows;

    if (memcmp(f, "DF", len < 2 ? len : 2) != 0)
        return 0;
    if (len < FRAME_HEAD)
        return FRAME_HEAD;
    cols = dx_get_u16(f + 2);
    rows = dx_get_u16(f + 4);
    if (cols < 2 || cols > MAX_COLS || rows < 2 || rows > MAX_ROWS)
        return 0;
    return FRAME_HEAD + 2 * (size_t)cols * rows;
}

/* Drops bytes up to where a frame may begin: a line may lose some. */
static void find_frame(struct dx_device *dev)
{
    uint8_t *f = dev->block + BLOCK_HEAD;
    size_t skip = 0;

    while (skip < dev->len && frame_len(f + skip, dev->len - skip) == 0)
        skip++;
    if (skip == 0)
        return;
    dev->len -= skip;
    memmove(f, f + skip, dev->len);
    dev->n_damaged++;
}

static void count_lost(struct dx_device *dev, uint32_t number)
{
    if (dev->any)
        dev->n_lost += (uint32_t)(number - dev->number - 1);
    dev->any = true;
    dev->number = number;
}

/* Waits at most 100 ms, so that silence is noticed; wake() ends it at once. */
static int wait_for_bytes(struct dx_device *dev)
{
    struct pollfd p[2] = {{dev->fd, POLLIN, 0}, {dev->wake_fd, POLLIN, 0}};
    ssize_t taken;
    uint64_t n;

    if (poll(p, 2, 100) <= 0)
        return DX_DRIVER_E_AGAIN;
    if (!p[1].revents)
        return 0;
    taken = read(dev->wake_fd, &n, sizeof(n));
    (void)taken; /* EAGAIN: it is */
    return DX_DRIVER_E_AGAIN;
}

/* Bytes up to `want` of the frame, no further: the next one stays in the line. */
static int take_bytes(struct dx_device *dev, size_t want, struct dx_err *err)
{
    ssize_t n = read(dev->fd, dev->block + BLOCK_HEAD + dev->len, want - dev->len);

    if (n > 0) {
        dev->len += (size_t)n;
        return 0;
    }
    if (n < 0 && (errno == EAGAIN || errno == EINTR))
        return DX_DRIVER_E_AGAIN;
    if (n < 0 && errno != EIO && errno != ENODEV)
        return dx_err_set(err, -errno, "template: %s: %s", dev->node, strerror(errno));
    return dx_err_set(err, DX_DRIVER_E_GONE, "template: %s: the camera was unplugged", dev->node);
}

/* Never more than one wait: the caller wants to look at its clock. */
static int template_read(struct dx_device *dev, struct dx_block *block, struct dx_err *err)
{
    const uint8_t *f = dev->block + BLOCK_HEAD;
    size_t want;
    int r;

    if (dev->given)
        dev->len = 0;
    dev->given = false;
    r = wait_for_bytes(dev);
    want = dev->len ? frame_len(f, dev->len) : FRAME_HEAD;
    if (r == 0)
        r = take_bytes(dev, want, err);
    if (r)
        return r;
    find_frame(dev);
    if (dev->len < FRAME_HEAD || dev->len < frame_len(f, dev->len))
        return DX_DRIVER_E_AGAIN;
    dev->given = true;
    count_lost(dev, dx_get_u32(f + 6));
    *block = (struct dx_block){.bytes = dev->block,
                               .len = BLOCK_HEAD + dev->len,
                               .stamp = {.host_ns = dx_clock_ns()},
                               .source = dev->node};
    return 0;
}

/* ---- decode: from the block and the blocks before it, and nothing else -----------------------
 */

static int tell_geometry(struct dx_device *dev, uint32_t rows, uint32_t cols, float unit_m,
                         const struct dx_frame_sink *sink, struct dx_err *err)
{
    struct dx_geometry *g;
    int r;

    if (dev->geometry && dev->geometry->height == rows && dev->geometry->width == cols &&
        dx_f32_bits(dev->geometry->unit_m) == dx_f32_bits(unit_m))
        return 0; /* told again only when it has changed */
    r = dx_geometry_new_pinhole(&g, rows, cols, FOCAL, FOCAL, cols / 2.0, rows / 2.0);
    if (r)
        return dx_err_set(err, r, "template: no geometry: %s", strerror(-r));
    g->unit_m = unit_m;
    dx_geometry_orient(g);
    r = sink->geometry(sink->ctx, g, 0);
    dx_geometry_unref(dev->geometry);
    dev->geometry = g;
    return r;
}

static int corrupt(const struct dx_block *b, struct dx_err *err, size_t offset, const char *what)
{
    return dx_err_set(err, DX_DRIVER_E_CORRUPT, "%s: block %llu: byte %zu: %s", b->source,
                      (unsigned long long)b->number, offset, what);
}

static int template_decode(struct dx_device *dev, const struct dx_block *b,
                           const struct dx_frame_sink *sink, struct dx_err *err)
{
    struct dx_plane *plane;
    uint32_t rows, cols;
    const uint8_t *f;
    float mm;
    int r;

    /* whatever a file holds comes through here */
    if (b->len < BLOCK_HEAD + FRAME_HEAD || dx_get_u32(b->bytes) != BLOCK_MAGIC)
        return corrupt(b, err, 0, "found no block of this driver");
    if (dx_get_u16(b->bytes + 4) != BLOCK_VERSION)
        return corrupt(b, err, 4, "found another version, expected 1");
    f = b->bytes + BLOCK_HEAD;
    mm = dx_f32_from_bits(dx_get_u32(b->bytes + 8));
    if (!(mm > 0 && mm < 1000))
        return corrupt(b, err, 8, "found no unit, expected 0 to 1000 mm");
    if (frame_len(f, b->len - BLOCK_HEAD) != b->len - BLOCK_HEAD)
        return corrupt(b, err, BLOCK_HEAD, "found no frame of this length");
    cols = dx_get_u16(f + 2);
    rows = dx_get_u16(f + 4);
    /* A driver whose frames are several blocks drops here what it has half of when b->first. */
    r = tell_geometry(dev, rows, cols, mm * 1e-3f, sink, err);
    if (r)
        return r;
    plane = sink->plane(sink->ctx, dev->frame);
    if (!plane)
        return DX_DRIVER_E_AGAIN;
    for (size_t k = 0; k < (size_t)rows * cols; k++)
        ((uint16_t *)plane->range)[k] = dx_get_u16(f + FRAME_HEAD + 2 * k);
    sink->deliver(sink->ctx,
                  &(struct dx_frame_part){
                      .frame = dev->frame++, .n_cols = cols, .last = true, .stamp = b->stamp});
    return 0;
}

/* A decoder that begins in the middle of a recording: NULL would do here, since each block has it
 * all. */
static int template_adopt(struct dx_device *dev, struct dx_geometry *g, uint8_t attr_bytes,
                          const struct dx_frame_sink *sink, struct dx_err *err)
{
    (void)err;
    dx_geometry_unref(dev->geometry);
    dev->geometry = dx_geometry_ref(g);
    return sink->geometry(sink->ctx, g, attr_bytes);
}

/* ---- the rest --------------------------------------------------------------------------------
 */

/* Also when the device is gone: nothing here may wait for it. */
static void template_stop(struct dx_device *dev)
{
    if (dev->fd >= 0 && write(dev->fd, "NO", 2) < 0)
        return;
}

static void template_wake(struct dx_device *dev)
{
    uint64_t one = 1;
    ssize_t r = write(dev->wake_fd, &one, sizeof(one));

    (void)r; /* EAGAIN: it is awake */
}

static uint64_t template_silence_ns(const struct dx_device *dev)
{
    (void)dev;
    return 5 * (uint64_t)PERIOD_NS;
}

static void template_health(const struct dx_device *dev, struct dx_device_health *out)
{
    struct dx_udev_device d;

    if (dx_udev_by_node(&d, dev->node, NULL) == 0) {
        snprintf(out->serial, sizeof(out->serial), "%s", d.serial);
        snprintf(out->place, sizeof(out->place), "%s", d.place);
    }
    out->n_lost = dev->n_lost;
    out->n_damaged = dev->n_damaged;
}

struct finding {
    void (*found)(void *ctx, const struct dx_device_found *device);
    void *ctx;
};

static bool on_tty(void *finding, const struct dx_udev_device *d)
{
    const struct finding *f = finding;
    char yaml[128];

    if (d->vendor != 0x1209 || d->product != 0x0001) /* the imaginary maker's */
        return true;
    snprintf(yaml, sizeof(yaml), "node: %s\n", d->node);
    f->found(f->ctx, &(struct dx_device_found){"imaginary depth camera", d->node, d->serial,
                                               d->place, yaml, dx_udev_access(d->node)});
    return true;
}

static int template_probe(void (*found)(void *ctx, const struct dx_device_found *device), void *ctx,
                          struct dx_err *err)
{
    return dx_udev_each("tty", on_tty, &(struct finding){found, ctx}, err);
}

static void template_describe(struct dx_device *dev, char *text, size_t len)
{
    snprintf(text, len, "imaginary depth camera: %llu frames", (unsigned long long)dev->frame);
}

static const char *const template_subsystems[] = {"tty", NULL};

/* In drivers/NAME/NAME.h as extern, and in the list of drivers/drivers.c. */
const struct dx_driver dx_template_driver = {
    .name = "template",
    .subsystems = template_subsystems,
    .open = template_open,
    .open_decoder = template_open_decoder,
    .start = template_start,
    .read = template_read,
    .decode = template_decode,
    .adopt = template_adopt,
    .stop = template_stop,
    .close = template_close,
    .wake = template_wake,
    .silence_ns = template_silence_ns,
    .health = template_health,
    .probe = template_probe,
    .describe = template_describe,
};
