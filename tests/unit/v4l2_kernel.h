/*
 * A scripted kernel with depth cameras, for tests: umockdev makes the nodes and what sysfs has of
 * them; ioctl() and poll() are the linker's wraps, and are answered here as videobuf2 does (a wait
 * tells what the script's next step is, and the wake's descriptor is really waited for). Buffers
 * are parts of the node's file. One camera streams at a time. It is our idea of the kernel:
 * `make hil` has the real one.
 */
#ifndef V4L2_KERNEL_H
#define V4L2_KERNEL_H

#include "tests/unit/umock_fixture.h"

#include <linux/videodev2.h>

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#define KERNEL_BUFFERS 4
#ifndef KERNEL_ROOM
#define KERNEL_ROOM 65536 /* bytes of a buffer in the file */
#endif
#define KERNEL_NODES 6

enum kernel_step {
    STEP_NONE, /* the script is over: nothing happens */
    STEP_FRAME,
    STEP_DAMAGED,
    STEP_SHORT,
    STEP_EAGAIN, /* these: what DQBUF says */
    STEP_EIO,
    STEP_EPIPE,
    STEP_EINVAL,
    STEP_ENODEV,
    STEP_LOST,  /* the next three frames are never told */
    STEP_AHEAD, /* the next frame is told later, by */
    STEP_BACK,  /* this, after the one behind it */
    STEP_POLL_ERROR,
    STEP_UNPLUG,
    STEP_CHANGE, /* the source has `next_width` now, and an event tells */
    STEP_END,
    STEP_OTHER, /* an event that is none of these, with a frame */
};

struct kernel_node {
    const char *name, *serial; /* "video0"; serial of the USB device */
    uint32_t formats[4];       /* 0 ends */
    uint32_t caps;
};

static struct kernel {
    UMockdevTestbed *bed;
    struct kernel_node nodes[KERNEL_NODES];
    unsigned n_nodes, ports; /* bits: those that have a USB device */

    /* the camera */
    bool planar;
    uint32_t width, height, bytesperline, fourcc, next_width, data_offset;
    uint32_t n_given, buffer_len; /* 0: as asked, as needed */
    uint32_t stamp_flags;
    struct v4l2_fract rate;
    bool streaming, event, ended, other, gone;
    unsigned queue[KERNEL_BUFFERS], n_queued, n_buffers;
    uint32_t sequence;
    uint8_t *memory; /* of the node that streams */

    /* the script */
    enum kernel_step script[64];
    unsigned at, n_polls;
    int timeout_ms;                       /* of the last poll */
    unsigned n_pauses, pauses_to_removal; /* after so many `removed` leaves sysfs; 0: never */
    const char *removed;

    /* what was asked */
    struct v4l2_format asked;
    unsigned n_ioctls, fail_at, n_on, n_off, n_released; /* fail_at counts from 1; 0: none */
    int fail_code;
    bool refuse_open;
    uint64_t frame_ns,
        due_ns;       /* not 0: a frame comes each so often, the next one then; no script */
    uint64_t told_ns; /* when the last one that was told was due */
    int64_t ahead_ns; /* of the clock */
} kernel;

/* ---- ioctls -------------------------------------------------------------------------------------
 */

/* The camera behind a descriptor. NULL: it is not there any more, or is none. */
static const struct kernel_node *kernel_node(int fd)
{
    char link[64], path[512] = "";
    const char *name;

    snprintf(link, sizeof(link), "/proc/self/fd/%d", fd);
    if (readlink(link, path, sizeof(path) - 1) < 0)
        return NULL;
    name = strrchr(path, '/') + 1;
    for (unsigned k = 0; k < kernel.n_nodes; k++)
        if (!strcmp(name, kernel.nodes[k].name))
            return &kernel.nodes[k];
    return NULL;
}

static uint32_t kernel_len(void)
{
    if (kernel.buffer_len)
        return kernel.buffer_len;
    return kernel.data_offset +
           kernel.bytesperline * kernel.height * (kernel.fourcc == V4L2_PIX_FMT_INZI ? 2 : 1);
}

/* Every pixel of frame n: 1000 + n, and the first one counts columns as well. */
static void kernel_draw(uint8_t *bytes, uint32_t n)
{
    for (uint32_t i = 0; i < kernel.height; i++)
        for (uint32_t j = 0; j < kernel.width; j++) {
            uint16_t v = (uint16_t)(1000 + n + (i == 0 ? j : 0));

            memcpy(bytes + kernel.data_offset + i * kernel.bytesperline + 2 * j, &v, 2);
        }
}

static int kernel_dequeue(struct v4l2_buffer *b, struct v4l2_plane *plane)
{
    enum kernel_step step = kernel.frame_ns ? STEP_FRAME : kernel.script[kernel.at];
    uint32_t used = kernel_len();

    if (step == STEP_NONE)
        return EAGAIN;
    if (!kernel.frame_ns && (step < STEP_LOST || step == STEP_OTHER))
        kernel.at++;
    switch (step) {
    case STEP_FRAME:
    case STEP_OTHER:
    case STEP_DAMAGED:
    case STEP_SHORT:
        break;
    case STEP_EIO:
        return EIO;
    case STEP_EPIPE:
        return EPIPE;
    case STEP_EINVAL:
        return EINVAL;
    case STEP_ENODEV:
        return ENODEV;
    default:
        return EAGAIN;
    }
    if (!kernel.streaming || kernel.n_queued == 0)
        return EINVAL;
    b->index = kernel.queue[0];
    memmove(kernel.queue, kernel.queue + 1, --kernel.n_queued * sizeof(kernel.queue[0]));
    if (!kernel.frame_ns) /* it would be the reader's time */
        kernel_draw(kernel.memory + (size_t)b->index * KERNEL_ROOM, kernel.sequence);
    b->sequence = kernel.sequence++;
    b->flags = kernel.stamp_flags | (step == STEP_DAMAGED ? V4L2_BUF_FLAG_ERROR : 0);
    b->timestamp.tv_sec = 3;
    b->timestamp.tv_usec = (suseconds_t)b->sequence;
    used -= step == STEP_SHORT;
    if (kernel.planar) {
        plane[0].bytesused = used;
        plane[0].data_offset = kernel.data_offset;
    }
    b->bytesused = kernel.planar ? 0 : used;
    return 0;
}

static void kernel_put_format(struct v4l2_format *f)
{
    if (kernel.planar) {
        f->fmt.pix_mp.width = kernel.width;
        f->fmt.pix_mp.height = kernel.height;
        f->fmt.pix_mp.pixelformat = kernel.fourcc;
        f->fmt.pix_mp.num_planes = 1;
        f->fmt.pix_mp.plane_fmt[0].bytesperline = kernel.bytesperline;
        f->fmt.pix_mp.plane_fmt[0].sizeimage = kernel_len();
    } else {
        f->fmt.pix.width = kernel.width;
        f->fmt.pix.height = kernel.height;
        f->fmt.pix.pixelformat = kernel.fourcc;
        f->fmt.pix.bytesperline = kernel.bytesperline;
        f->fmt.pix.sizeimage = kernel_len();
    }
}

static void kernel_place(struct v4l2_buffer *b, struct v4l2_plane *plane)
{
    if (kernel.planar) {
        plane[0].length = kernel_len();
        plane[0].m.mem_offset = b->index * KERNEL_ROOM;
    } else {
        b->length = kernel_len();
        b->m.offset = b->index * KERNEL_ROOM;
    }
}

static int kernel_request(struct v4l2_requestbuffers *r)
{
    if (kernel.streaming)
        return EBUSY;
    kernel.n_released += r->count == 0;
    kernel.n_queued = 0;
    if (r->count > KERNEL_BUFFERS)
        r->count = kernel.n_given ? kernel.n_given : KERNEL_BUFFERS;
    kernel.n_buffers = r->count;
    return 0;
}

static int kernel_event(struct v4l2_event *e)
{
    if (!kernel.event && !kernel.ended && !kernel.other)
        return ENOENT;
    e->type = kernel.event   ? V4L2_EVENT_SOURCE_CHANGE
              : kernel.other ? V4L2_EVENT_CTRL
                             : V4L2_EVENT_EOS;
    kernel.event = kernel.other = false;
    return 0;
}

static int kernel_stream(bool on)
{
    kernel.n_on += on;
    kernel.n_off += !on;
    kernel.streaming = on;
    kernel.sequence = on ? 0 : kernel.sequence;
    kernel.n_queued = on ? kernel.n_queued : 0;
    return 0;
}

static int kernel_answer(const struct kernel_node *node, unsigned long request, void *p,
                         struct v4l2_plane *plane)
{
    struct v4l2_capability *cap = p;
    struct v4l2_fmtdesc *desc = p;
    struct v4l2_buffer *buffer = p;

    switch (request) {
    case VIDIOC_QUERYCAP:
        strcpy((char *)cap->card, "Depth One");
        cap->capabilities = V4L2_CAP_DEVICE_CAPS | V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING |
                            V4L2_CAP_VIDEO_CAPTURE;
        cap->device_caps = node->caps;
        return 0;
    case VIDIOC_ENUM_FMT:
        if (desc->index >= 4 || !node->formats[desc->index])
            return EINVAL;
        desc->pixelformat = node->formats[desc->index];
        return 0;
    case VIDIOC_S_FMT:
        memcpy(&kernel.asked, p, sizeof(kernel.asked));
        /* fallthrough */
    case VIDIOC_G_FMT:
        kernel_put_format(p);
        return 0;
    case VIDIOC_S_PARM:
        kernel.rate = ((struct v4l2_streamparm *)p)->parm.capture.timeperframe;
        return 0;
    case VIDIOC_G_PARM:
        ((struct v4l2_streamparm *)p)->parm.capture.timeperframe = kernel.rate;
        return 0;
    case VIDIOC_REQBUFS:
        return kernel_request(p);
    case VIDIOC_QUERYBUF:
        kernel_place(buffer, plane);
        return 0;
    case VIDIOC_QBUF:
        kernel.queue[kernel.n_queued++ % KERNEL_BUFFERS] = buffer->index;
        return kernel.n_queued > KERNEL_BUFFERS ? EINVAL : 0;
    case VIDIOC_DQBUF:
        return kernel_dequeue(buffer, plane);
    case VIDIOC_STREAMON:
        return kernel_stream(true);
    case VIDIOC_STREAMOFF:
        return kernel_stream(false);
    case VIDIOC_DQEVENT:
        return kernel_event(p);
    case VIDIOC_SUBSCRIBE_EVENT:
        return EINVAL; /* as uvcvideo */
    default:
        return ENOTTY;
    }
}

static int kernel_ioctl(const struct kernel_node *node, unsigned long request, void *arg)
{
    struct v4l2_plane *planes = NULL;
    int code = kernel.gone || !node ? ENODEV : 0;

    if (kernel.planar && (request == VIDIOC_QUERYBUF || request == VIDIOC_DQBUF))
        planes = ((struct v4l2_buffer *)arg)->m.planes;
    if (++kernel.n_ioctls == kernel.fail_at)
        code = kernel.fail_code;
    return code ? code : kernel_answer(node, request, arg, planes);
}

/* ---- the linker's wraps -------------------------------------------------------------------------
 */

int __real_poll(struct pollfd *fd, nfds_t n, int timeout_ms);
int __wrap_poll(struct pollfd *fd, nfds_t n, int timeout_ms);
int __wrap_ioctl(int fd, unsigned long request, void *arg);
int __real_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags, ...);
int __real_clock_gettime(clockid_t id, struct timespec *t);
int __wrap_clock_gettime(clockid_t id, struct timespec *t);

/* What videobuf2 and the script say to a wait. */
static short kernel_poll(void)
{
    enum kernel_step step = kernel.script[kernel.at];

    if (kernel.gone || step == STEP_UNPLUG) {
        kernel.gone = true;
        return POLLERR | POLLHUP | POLLPRI;
    }
    if (step == STEP_POLL_ERROR) {
        kernel.at++;
        return POLLERR;
    }
    if (step == STEP_CHANGE) {
        kernel.at++;
        kernel.width = kernel.next_width;
        kernel.bytesperline = 2 * kernel.width;
        kernel.event = true;
    }
    if (step == STEP_END) {
        kernel.at++;
        kernel.ended = true;
    }
    if (step == STEP_OTHER)
        kernel.other = true;
    if (kernel.event || kernel.ended || kernel.other)
        return kernel.other ? POLLPRI | POLLIN : POLLPRI;
    if (step == STEP_NONE)
        return 0;
    return kernel.n_queued ? POLLIN : POLLERR;
}

/* Frames by the clock. One that nobody has waited for is told at once, and so late. */
static int kernel_poll_paced(struct pollfd *fd, int timeout_ms)
{
    struct timespec now, left = {timeout_ms / 1000, timeout_ms % 1000 * 1000000};
    uint64_t now_ns;

    clock_gettime(CLOCK_MONOTONIC, &now);
    now_ns = (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
    if (kernel.due_ns > now_ns)
        left = (struct timespec){0, (long)(kernel.due_ns - now_ns)};
    else
        left = (struct timespec){0, 0};
    fd[0].revents = 0;
    if (ppoll(fd + 1, 1, &left, NULL) > 0)
        return 1;
    kernel.told_ns = kernel.due_ns;
    kernel.due_ns += kernel.frame_ns;
    fd[0].revents = POLLIN;
    return 1;
}

int __wrap_poll(struct pollfd *fd, nfds_t n, int timeout_ms)
{
    if (n == 0) { /* a pause */
        if (++kernel.n_pauses == kernel.pauses_to_removal)
            umockdev_testbed_remove_device(kernel.bed, kernel.removed);
        return 0;
    }
    if (n != 2 || !(fd[0].events & POLLPRI))
        return __real_poll(fd, n, timeout_ms);
    if (kernel.frame_ns)
        return kernel_poll_paced(fd, timeout_ms);
    kernel.n_polls++;
    kernel.timeout_ms = timeout_ms;
    for (; kernel.script[kernel.at] >= STEP_LOST && kernel.script[kernel.at] <= STEP_BACK;
         kernel.at++)
        kernel.sequence += (uint32_t[]){3, 1, (uint32_t)-2}[kernel.script[kernel.at] - STEP_LOST];
    fd[0].revents = kernel_poll();
    fd[1].revents = 0;
    return __real_poll(fd + 1, 1, fd[0].revents ? 0 : timeout_ms) + (fd[0].revents != 0);
}

int __wrap_ioctl(int fd, unsigned long request, void *arg)
{
    int code = kernel_ioctl(kernel_node(fd), request, arg);

    errno = code ? code : errno;
    return code ? -1 : 0;
}

int __wrap_open(const char *path, int flags, ...)
{
    if (kernel.refuse_open && !strncmp(path, "/dev/video", 10)) {
        errno = EACCES;
        return -1;
    }
    return __real_open(path, flags, 0600);
}

int __wrap_clock_gettime(clockid_t id, struct timespec *t)
{
    int r = __real_clock_gettime(id, t);

    t->tv_sec += kernel.ahead_ns / 1000000000;
    return r;
}

#endif
