/*
 * The V4L2 driver: a decoder, and for as long as a camera is open, a stream of it. Owned by the
 * reader thread; wake() from any.
 */
#include "drivers/v4l2/v4l2.h"

#include "drivers/monotonic.h"
#include "drivers/v4l2/v4l2_decode.h"
#include "drivers/v4l2/v4l2_find.h"
#include "drivers/v4l2/v4l2_stream.h"

#include <errno.h>
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define SILENT_FRAMES    5
#define SILENT_LEAST_NS  500000000u
#define FPS_WHEN_UNKNOWN 10.0
#define REMOVAL_STEP_MS  10
#define REMOVAL_STEPS    50           /* what was unplugged by a word alone stays in sysfs */
#define TROUBLE_NS       60000000000u /* a restart is told of for so long */

struct dx_device {
    struct dx_v4l2_decoder decoder;
    struct dx_v4l2_stream stream;
    char serial[64], place[128];
    char parent[256]; /* in sysfs: the USB interface of the node */
};

static int check(const struct dx_v4l2_config *c, struct dx_err *err)
{
    if (!(c->unit_m >= DX_V4L2_MIN_UNIT && c->unit_m <= DX_V4L2_MAX_UNIT))
        return dx_err_set(err, -EINVAL, "v4l2: unit is %g m, expected %g to %g", c->unit_m,
                          DX_V4L2_MIN_UNIT, DX_V4L2_MAX_UNIT);
    if (!(c->fps >= 0 && c->fps <= 1e6))
        return dx_err_set(err, -EINVAL, "v4l2: fps is %g, expected 0 to 1e6", c->fps);
    if (!(c->min_m >= 0 && c->max_m >= 0) || (c->max_m > 0 && c->min_m >= c->max_m))
        return dx_err_set(err, -EINVAL, "v4l2: depths from %g to %g m, expected less to more",
                          c->min_m, c->max_m);
    if (c->disparity_given && !(fabs(c->disparity[0]) > 0))
        return dx_err_set(err, -EINVAL, "v4l2: disparity of k 0, expected another");
    return 0;
}

/*
 * The kernel tells that a camera was unplugged while it is still taking it down, and Linux 6.1
 * falls over when the node is closed in that moment (media_device_unregister_entity() looks at the
 * media device before it takes its lock: seen as a null pointer in ida_free()). The interface
 * leaves sysfs when the camera is all down.
 */
static void await_removal(const struct dx_device *dev)
{
    for (int k = 0; k < REMOVAL_STEPS && access(dev->parent, F_OK) == 0; k++)
        poll(NULL, 0, REMOVAL_STEP_MS);
}

static void set_parent(struct dx_device *dev, const char *syspath)
{
    snprintf(dev->parent, sizeof(dev->parent), "%s", syspath);
    for (int k = 0; k < 2; k++) { /* "/video4linux/video0" */
        char *slash = strrchr(dev->parent, '/');

        if (slash)
            *slash = 0;
    }
}

static void v4l2_close(struct dx_device *dev)
{
    if (!dev)
        return;
    if (dev->stream.gone)
        await_removal(dev);
    dx_v4l2_stream_close(&dev->stream);
    dx_v4l2_decoder_fini(&dev->decoder);
    free(dev);
}

static int v4l2_open_decoder(struct dx_device **out, const void *config, struct dx_err *err)
{
    const struct dx_v4l2_config *c = config;
    struct dx_device *dev;
    int r = check(c, err);

    if (r)
        return r;
    dev = calloc(1, sizeof(*dev));
    if (!dev)
        return dx_err_set(err, -ENOMEM, "v4l2: no memory");
    r = dx_v4l2_stream_init(&dev->stream, c, err);
    if (r) {
        free(dev);
        return r;
    }
    dx_v4l2_decoder_init(&dev->decoder, c);
    *out = dev;
    return 0;
}

static int v4l2_open(struct dx_device **out, const void *config, struct dx_err *err)
{
    struct dx_udev_device d;
    struct dx_device *dev = NULL;
    int r = v4l2_open_decoder(&dev, config, err);

    if (r)
        return r;
    r = dx_v4l2_find(&d, config, err);
    if (r == 0) {
        set_parent(dev, d.syspath);
        r = dx_v4l2_stream_open(&dev->stream, d.node, err);
    }
    if (r == 0) /* what the lens cannot show is told now, not at each frame */
        r = dx_v4l2_decoder_fit(&dev->decoder, &dev->stream.capture.shape, err);
    if (r) {
        v4l2_close(dev);
        return r;
    }
    snprintf(dev->serial, sizeof(dev->serial), "%s", d.serial);
    snprintf(dev->place, sizeof(dev->place), "%s", d.place);
    *out = dev;
    return 0;
}

static int v4l2_start(struct dx_device *dev, struct dx_err *err)
{
    return dx_v4l2_stream_start(&dev->stream, err);
}

static int v4l2_read(struct dx_device *dev, struct dx_block *block, struct dx_err *err)
{
    return dx_v4l2_stream_read(&dev->stream, block, err);
}

static int v4l2_decode(struct dx_device *dev, const struct dx_block *block,
                       const struct dx_frame_sink *sink, struct dx_err *err)
{
    return dx_v4l2_decode(&dev->decoder, block, sink, err);
}

static void v4l2_stop(struct dx_device *dev)
{
    dx_v4l2_stream_stop(&dev->stream);
}

static void v4l2_wake(struct dx_device *dev)
{
    dx_v4l2_stream_wake(&dev->stream);
}

static uint64_t v4l2_silence_ns(const struct dx_device *dev)
{
    double fps = dev->stream.capture.fps;
    double ns = 1e9 * SILENT_FRAMES / (fps > 0 ? fps : FPS_WHEN_UNKNOWN);

    return ns > SILENT_LEAST_NS ? (uint64_t)(ns < 1e12 ? ns : 1e12) : SILENT_LEAST_NS;
}

static void v4l2_health(const struct dx_device *dev, struct dx_device_health *out)
{
    const struct dx_v4l2_stream *s = &dev->stream;
    uint64_t newest = s->failure_ns[DX_V4L2_MAX_FAILURES - 1];

    *out = (struct dx_device_health){.n_lost = s->n_lost, .n_damaged = s->n_damaged};
    snprintf(out->serial, sizeof(out->serial), "%s", dev->serial);
    snprintf(out->place, sizeof(out->place), "%s", dev->place);
    if (newest && dx_clock_ns() - newest < TROUBLE_NS)
        snprintf(out->trouble, sizeof(out->trouble),
                 "the stream failed and was started anew, %llu in all",
                 (unsigned long long)s->n_restarts);
}

static void v4l2_describe(struct dx_device *dev, char *text, size_t len)
{
    const struct dx_v4l2_capture *c = &dev->stream.capture;
    const struct dx_v4l2_decoder *d = &dev->decoder;
    const struct dx_v4l2_shape *s = c->fd >= 0 ? &c->shape : &d->shape;
    const char *model = d->geometry ? dx_model_name(d->geometry->model) : "no frame yet";
    size_t n = 0;

    if (c->fd >= 0)
        n = (size_t)snprintf(text, len, "%s: %s, ", c->node, c->card);
    if (n < len)
        n +=
            (size_t)snprintf(text + n, len - n, "%s %ux%u, unit %g m, %s",
                             dx_v4l2_format_name(s->format), s->width, s->height, s->unit_m, model);
    if (c->fd >= 0 && c->fps > 0 && n < len)
        n += (size_t)snprintf(text + n, len - n, ", %g frames a second", c->fps);
    if (d->n_beyond && n < len)
        snprintf(text + n, len - n, ", %llu ranges beyond 16 bits",
                 (unsigned long long)d->n_beyond);
}

static const char *const subsystems[] = {"video4linux", NULL};

const struct dx_driver dx_v4l2_driver = {
    .name = "v4l2",
    .subsystems = subsystems,
    .open = v4l2_open,
    .open_decoder = v4l2_open_decoder,
    .start = v4l2_start,
    .read = v4l2_read,
    .decode = v4l2_decode,
    .stop = v4l2_stop,
    .close = v4l2_close,
    .wake = v4l2_wake,
    .silence_ns = v4l2_silence_ns,
    .health = v4l2_health,
    .probe = dx_v4l2_probe,
    .describe = v4l2_describe,
};
