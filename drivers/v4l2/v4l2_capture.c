/* Opening a node and settling its format. */
#include "drivers/v4l2/v4l2_capture_priv.h"

#include <linux/videodev2.h>

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#define MAX_FORMATS 256 /* a driver that never ends is none */

int dx_v4l2_call(const struct dx_v4l2_capture *c, unsigned long request, void *arg)
{
    int r;

    do
        r = ioctl(c->fd, request, arg);
    while (r < 0 && errno == EINTR);
    return r < 0 ? -errno : 0;
}

int dx_v4l2_failed(const struct dx_v4l2_capture *c, int code, const char *what, struct dx_err *err)
{
    if (code == -ENODEV)
        return dx_err_set(err, DX_DRIVER_E_GONE, "%s: unplugged", c->node);
    return dx_err_set(err, code, "%s: %s: %s", c->node, what, strerror(-code));
}

uint32_t dx_v4l2_type(const struct dx_v4l2_capture *c)
{
    return c->planar ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE : V4L2_BUF_TYPE_VIDEO_CAPTURE;
}

/* ---- opening ------------------------------------------------------------------------------------
 */

static int query(struct dx_v4l2_capture *c, struct dx_err *err)
{
    struct v4l2_capability cap = {0};
    int r = dx_v4l2_call(c, VIDIOC_QUERYCAP, &cap);
    uint32_t caps = cap.capabilities & V4L2_CAP_DEVICE_CAPS ? cap.device_caps : cap.capabilities;

    if (r == -ENOTTY || r == -EINVAL)
        return dx_err_set(err, -ENOTSUP, "%s: not a video device", c->node);
    if (r)
        return dx_v4l2_failed(c, r, "VIDIOC_QUERYCAP", err);
    snprintf(c->card, sizeof(c->card), "%.32s", (const char *)cap.card);
    snprintf(c->bus, sizeof(c->bus), "%.32s", (const char *)cap.bus_info);
    c->planar = !(caps & V4L2_CAP_VIDEO_CAPTURE) && (caps & V4L2_CAP_VIDEO_CAPTURE_MPLANE);
    if (!(caps & (V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_VIDEO_CAPTURE_MPLANE)) ||
        !(caps & V4L2_CAP_STREAMING))
        return dx_err_set(err, -ENOTSUP, "%s: %s: captures no video, or does not stream", c->node,
                          c->card);
    return 0;
}

int dx_v4l2_capture_open(struct dx_v4l2_capture *c, const char *node, struct dx_err *err)
{
    long page_len = sysconf(_SC_PAGESIZE);
    int r;

    *c = (struct dx_v4l2_capture){.page_len = page_len > 0 ? (size_t)page_len : 65536};
    snprintf(c->node, sizeof(c->node), "%s", node);
    c->fd = open(node, O_RDWR | O_NONBLOCK | O_CLOEXEC);
    if (c->fd < 0) {
        r = -errno;
        if (r == -ENOENT || r == -ENXIO || r == -ENODEV)
            return dx_err_set(err, DX_DRIVER_E_GONE, "%s: no such camera", node);
        return dx_err_set(err, r, "%s: %s", node, strerror(-r));
    }
    r = query(c, err);
    if (r)
        dx_v4l2_capture_close(c);
    return r;
}

void dx_v4l2_capture_close(struct dx_v4l2_capture *c)
{
    dx_v4l2_capture_unmap(c);
    if (c->fd >= 0)
        close(c->fd);
    c->fd = -1;
}

/* ---- format -------------------------------------------------------------------------------------
 */

int dx_v4l2_capture_has(const struct dx_v4l2_capture *c, enum dx_v4l2_format *format,
                        struct dx_err *err)
{
    bool has[DX_V4L2_N_FORMATS] = {false};
    struct v4l2_fmtdesc f = {.type = dx_v4l2_type(c)};
    const char *wanted = *format ? dx_v4l2_format_name(*format) : "Z16 or INZI";
    int r = 0;

    for (f.index = 0; f.index < MAX_FORMATS && r == 0; f.index++) {
        r = dx_v4l2_call(c, VIDIOC_ENUM_FMT, &f);
        if (r == 0)
            has[dx_v4l2_format_find(f.pixelformat)] = true;
    }
    if (r && r != -EINVAL) /* EINVAL: there are no more */
        return dx_v4l2_failed(c, r, "VIDIOC_ENUM_FMT", err);
    if (*format == DX_V4L2_AUTO)
        *format = has[DX_V4L2_Z16] ? DX_V4L2_Z16 : DX_V4L2_INZI;
    if (!has[*format])
        return dx_err_set(err, -ENOTSUP, "%s: %s: has no format %s", c->node, c->card, wanted);
    return 0;
}

void dx_v4l2_capture_size(const struct dx_v4l2_capture *c, uint32_t *width, uint32_t *height)
{
    struct v4l2_format f = {.type = dx_v4l2_type(c)};

    *width = *height = 0;
    if (dx_v4l2_call(c, VIDIOC_G_FMT, &f))
        return;
    *width = c->planar ? f.fmt.pix_mp.width : f.fmt.pix.width;
    *height = c->planar ? f.fmt.pix_mp.height : f.fmt.pix.height;
}

static void put_format(const struct dx_v4l2_capture *c, struct v4l2_format *f, uint32_t fourcc,
                       uint32_t width, uint32_t height)
{
    *f = (struct v4l2_format){.type = dx_v4l2_type(c)};
    if (c->planar) {
        f->fmt.pix_mp.width = width;
        f->fmt.pix_mp.height = height;
        f->fmt.pix_mp.pixelformat = fourcc;
        f->fmt.pix_mp.field = V4L2_FIELD_NONE;
        f->fmt.pix_mp.num_planes = 1;
    } else {
        f->fmt.pix.width = width;
        f->fmt.pix.height = height;
        f->fmt.pix.pixelformat = fourcc;
        f->fmt.pix.field = V4L2_FIELD_NONE;
    }
}

/* What the driver has made of it. */
static uint32_t take_format(struct dx_v4l2_capture *c, const struct v4l2_format *f)
{
    struct dx_v4l2_shape *s = &c->shape;

    if (c->planar) {
        s->width = f->fmt.pix_mp.width;
        s->height = f->fmt.pix_mp.height;
        s->bytesperline = f->fmt.pix_mp.plane_fmt[0].bytesperline;
        return f->fmt.pix_mp.pixelformat;
    }
    s->width = f->fmt.pix.width;
    s->height = f->fmt.pix.height;
    s->bytesperline = f->fmt.pix.bytesperline;
    return f->fmt.pix.pixelformat;
}

static int set_format(struct dx_v4l2_capture *c, const struct dx_v4l2_config *config,
                      struct dx_err *err)
{
    uint32_t width = config->width, height = config->height, got;
    const char *name = dx_v4l2_format_name(c->shape.format);
    struct dx_v4l2_layout layout;
    struct v4l2_format f;
    char why[96];
    int r;

    if (width == 0)
        dx_v4l2_capture_size(c, &width, &height);
    put_format(c, &f, dx_v4l2_format_fourcc(c->shape.format), width, height);
    r = dx_v4l2_call(c, VIDIOC_S_FMT, &f);
    if (r)
        return dx_v4l2_failed(c, r, "VIDIOC_S_FMT", err);
    got = take_format(c, &f);
    if (got != dx_v4l2_format_fourcc(c->shape.format))
        return dx_err_set(err, -EINVAL, "%s: gives pixel format %08x, expected %s", c->node, got,
                          name);
    if (config->width && (c->shape.width != width || c->shape.height != height))
        return dx_err_set(err, -EINVAL, "%s: gives %s of %ux%u, expected %ux%u", c->node, name,
                          c->shape.width, c->shape.height, width, height);
    if (c->shape.bytesperline == 0) /* some do not say, and mean no padding */
        c->shape.bytesperline =
            c->shape.format == DX_V4L2_Y10B ? c->shape.width / 4 * 5 : c->shape.width * 2;
    if (dx_v4l2_layout(&layout, &c->shape, why))
        return dx_err_set(err, -EINVAL, "%s: %s", c->node, why);
    return 0;
}

/* Cameras that cannot be asked keep what they have. */
static void set_rate(struct dx_v4l2_capture *c, double fps)
{
    struct v4l2_streamparm p = {.type = dx_v4l2_type(c)};
    const struct v4l2_fract *t = &p.parm.capture.timeperframe;
    int r = -EINVAL;

    if (fps > 0) {
        p.parm.capture.timeperframe =
            (struct v4l2_fract){.numerator = 1000, .denominator = (uint32_t)rint(1000 * fps)};
        r = dx_v4l2_call(c, VIDIOC_S_PARM, &p);
    }
    if (r)
        r = dx_v4l2_call(c, VIDIOC_G_PARM, &p);
    c->fps = r == 0 && t->numerator && t->denominator ? (double)t->denominator / t->numerator : 0;
}

/* That the kernel has none of them is usual (uvcvideo). */
static void subscribe(const struct dx_v4l2_capture *c)
{
    struct v4l2_event_subscription change = {.type = V4L2_EVENT_SOURCE_CHANGE};
    struct v4l2_event_subscription end = {.type = V4L2_EVENT_EOS};

    (void)dx_v4l2_call(c, VIDIOC_SUBSCRIBE_EVENT, &change);
    (void)dx_v4l2_call(c, VIDIOC_SUBSCRIBE_EVENT, &end);
}

enum dx_v4l2_event dx_v4l2_capture_event(struct dx_v4l2_capture *c)
{
    struct v4l2_event e = {0};

    if (dx_v4l2_call(c, VIDIOC_DQEVENT, &e))
        return DX_V4L2_NO_EVENT;
    switch (e.type) {
    case V4L2_EVENT_SOURCE_CHANGE:
        return DX_V4L2_SOURCE_CHANGED;
    case V4L2_EVENT_EOS:
        return DX_V4L2_STREAM_ENDED;
    default:
        return DX_V4L2_OTHER_EVENT;
    }
}

int dx_v4l2_capture_prepare(struct dx_v4l2_capture *c, const struct dx_v4l2_config *config,
                            struct dx_err *err)
{
    int r;

    c->shape = (struct dx_v4l2_shape){
        .format = config->format,
        .invalid = config->invalid,
        .unit_m = config->unit_m,
        .k = config->disparity_given ? config->disparity[0] : 0,
        .d0 = config->disparity_given ? config->disparity[1] : 0,
    };
    r = dx_v4l2_capture_has(c, &c->shape.format, err);
    if (r == 0)
        r = set_format(c, config, err);
    if (r)
        return r;
    set_rate(c, config->fps);
    subscribe(c);
    r = dx_v4l2_capture_map(c, err);
    if (r)
        dx_v4l2_capture_unmap(c);
    return r;
}
