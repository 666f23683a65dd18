/*
 * A scripted kernel with depth cameras, for tests: umockdev makes the nodes and takes the ioctls,
 * which are answered here as videobuf2 does; poll() is the linker's wrap, for umockdev has none
 * (a wait tells what the script's next step is, and the wake's descriptor is really waited for).
 * Buffers are parts of the node's file. One camera streams at a time. It is our idea of the kernel:
 * `make hil` has the real one.
 */
#ifndef V4L2_KERNEL_H
#define V4L2_KERNEL_H

#include <linux/videodev2.h>

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>
#include <umockdev.h>
#include <unistd.h>

#define KERNEL_BUFFERS 4
#define KERNEL_ROOM    65536 /* bytes of a buffer in the file */
#define KERNEL_NODES   6

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
    STEP_LOST, /* the next three frames are never told */
    STEP_POLL_ERROR,
    STEP_UNPLUG,
    STEP_CHANGE, /* the source has `next_width` now, and an event tells */
    STEP_END,
};

struct kernel_node {
    const char *name, *serial; /* "video0"; serial of the USB device */
    uint32_t formats[4];       /* 0 ends */
    uint32_t caps;
};

static struct kernel {
    UMockdevTestbed *bed;
    GMainContext *context;
    UMockdevIoctlBase *base;
    pthread_t thread;
    bool quit;
    struct kernel_node nodes[KERNEL_NODES];
    unsigned n_nodes, ports; /* bits: those that have a USB device */

    /* the camera */
    bool planar;
    uint32_t width, height, bytesperline, fourcc, next_width, data_offset;
    uint32_t n_given, buffer_len; /* 0: as asked, as needed */
    uint32_t stamp_flags;
    struct v4l2_fract rate;
    bool streaming, event, ended, gone;
    unsigned queue[KERNEL_BUFFERS], n_queued, n_buffers;
    uint32_t sequence;
    uint8_t *memory; /* of the node that streams */

    /* the script */
    enum kernel_step script[64];
    unsigned at, n_polls;
    int timeout_ms; /* of the last poll */

    /* what was asked */
    struct v4l2_format asked;
    unsigned n_ioctls, fail_at, n_on, n_off, n_released; /* fail_at counts from 1; 0: none */
    int fail_code;
    bool refuse_open;
    int64_t ahead_ns; /* of the clock */
} kernel;

/* ---- ioctls, in umockdev's thread ---------------------------------------------------------------
 */

static const struct kernel_node *kernel_node(UMockdevIoctlClient *client)
{
    const char *name = umockdev_ioctl_client_get_devnode(client);

    for (unsigned k = 0; k < kernel.n_nodes; k++)
        if (!strcmp(strrchr(name, '/') + 1, kernel.nodes[k].name))
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
    enum kernel_step step = kernel.script[kernel.at];
    uint32_t used = kernel_len();

    if (step == STEP_NONE)
        return EAGAIN;
    if (step < STEP_LOST)
        kernel.at++;
    switch (step) {
    case STEP_FRAME:
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
    if (!kernel.event && !kernel.ended)
        return ENOENT;
    e->type = kernel.event ? V4L2_EVENT_SOURCE_CHANGE : V4L2_EVENT_EOS;
    kernel.event = false;
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

static gboolean kernel_ioctl(UMockdevIoctlBase *base, UMockdevIoctlClient *client, gpointer data)
{
    gulong request = umockdev_ioctl_client_get_request(client);
    UMockdevIoctlData *arg = umockdev_ioctl_client_get_arg(client), *d, *planes = NULL;
    struct v4l2_plane *plane = NULL;
    int code;

    (void)base;
    (void)data;
    d = umockdev_ioctl_data_resolve(arg, 0, _IOC_SIZE(request), NULL);
    if (kernel.planar && (request == VIDIOC_QUERYBUF || request == VIDIOC_DQBUF)) {
        planes = umockdev_ioctl_data_resolve(d, offsetof(struct v4l2_buffer, m.planes),
                                             VIDEO_MAX_PLANES * sizeof(*plane), NULL);
        plane = (void *)planes->data;
    }
    code = kernel.gone ? ENODEV : 0;
    if (++kernel.n_ioctls == kernel.fail_at)
        code = kernel.fail_code;
    if (!code)
        code = kernel_answer(kernel_node(client), request, d->data, plane);
    umockdev_ioctl_client_complete(client, code ? -1 : 0, code);
    return TRUE;
}

static void *kernel_run(void *unused)
{
    g_main_context_push_thread_default(kernel.context);
    while (!__atomic_load_n(&kernel.quit, __ATOMIC_ACQUIRE))
        g_main_context_iteration(kernel.context, TRUE);
    g_main_context_pop_thread_default(kernel.context);
    return unused;
}

/* ---- waiting, opening and the clock: the linker's wraps
 * ------------------------------------------- */

int __real_poll(struct pollfd *fd, nfds_t n, int timeout_ms);
int __wrap_poll(struct pollfd *fd, nfds_t n, int timeout_ms);
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
    if (kernel.event || kernel.ended)
        return POLLPRI;
    if (step == STEP_NONE)
        return 0;
    return kernel.n_queued ? POLLIN : POLLERR;
}

int __wrap_poll(struct pollfd *fd, nfds_t n, int timeout_ms)
{
    if (n != 2 || !(fd[0].events & POLLPRI))
        return __real_poll(fd, n, timeout_ms);
    kernel.n_polls++;
    kernel.timeout_ms = timeout_ms;
    if (kernel.script[kernel.at] == STEP_LOST) {
        kernel.at++;
        kernel.sequence += 3;
    }
    fd[0].revents = kernel_poll();
    fd[1].revents = 0;
    return __real_poll(fd + 1, 1, fd[0].revents ? 0 : timeout_ms) + (fd[0].revents != 0);
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

/* ---- setting up ---------------------------------------------------------------------------------
 */

#define KERNEL_USB "/devices/pci0000:00/0000:00:14.0/usb1/1-"

/* A node of the USB device at port `port` of bus 1. */
static inline void kernel_plug(const char *name, unsigned port, const char *serial, uint32_t caps,
                               uint32_t format0, uint32_t format1)
{
    struct kernel_node *node = &kernel.nodes[kernel.n_nodes++];
    unsigned number = (unsigned)atoi(name + strlen("video"));
    char text[1200], path[256];
    GError *error = NULL;
    int fd;

    *node = (struct kernel_node){name, serial, {format0, format1}, caps};
    snprintf(text, sizeof(text),
             "P: " KERNEL_USB "%u\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nA: idVendor=8086\n"
             "A: idProduct=0ad3\nA: serial=%s\nA: devpath=%u\nA: busnum=1\nA: devnum=%u\n\n",
             port, serial, port, 10 + port);
    if (!(kernel.ports & 1u << port))
        umockdev_testbed_add_from_string(kernel.bed, text, NULL);
    snprintf(text, sizeof(text),
             "P: " KERNEL_USB "%u/1-%u:1.0\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_interface\n"
             "A: bInterfaceNumber=00\n\n",
             port, port);
    if (!(kernel.ports & 1u << port))
        umockdev_testbed_add_from_string(kernel.bed, text, NULL);
    kernel.ports |= 1u << port;
    snprintf(text, sizeof(text),
             "P: " KERNEL_USB "%u/1-%u:1.0/video4linux/%s\nN: %s=00\nE: SUBSYSTEM=video4linux\n"
             "S: v4l/by-path/port-%u-%s\nE: DEVNAME=/dev/%s\nE: MAJOR=81\nE: MINOR=%u\n"
             "A: name=Depth One\nA: index=0\n\n",
             port, port, name, name, port, name, name, number);
    if (!umockdev_testbed_add_from_string(kernel.bed, text, &error))
        fail_msg("%s", error->message);
    snprintf(path, sizeof(path), "/dev/%s", name);
    if (!umockdev_testbed_attach_ioctl(kernel.bed, path, kernel.base, &error))
        fail_msg("%s", error->message);
    fd = __real_open(path, O_RDWR | O_CLOEXEC);
    assert_true(fd >= 0);
    assert_int_equal(ftruncate(fd, (off_t)KERNEL_BUFFERS * KERNEL_ROOM), 0);
    if (kernel.memory)
        munmap(kernel.memory, (size_t)KERNEL_BUFFERS * KERNEL_ROOM);
    kernel.memory =
        mmap(NULL, (size_t)KERNEL_BUFFERS * KERNEL_ROOM, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    assert_true(kernel.memory != MAP_FAILED);
    close(fd);
}

static inline void kernel_unplug(const char *name, unsigned port)
{
    char path[256];

    snprintf(path, sizeof(path), "/dev/%s", name);
    umockdev_testbed_detach_ioctl(kernel.bed, path, NULL);
    snprintf(path, sizeof(path), "/sys" KERNEL_USB "%u/1-%u:1.0/video4linux/%s", port, port, name);
    umockdev_testbed_remove_device(kernel.bed, path);
    kernel.n_nodes = 0;
    kernel.gone = kernel.streaming = false;
}

static int kernel_set_up(void **state)
{
    (void)state;
    kernel = (struct kernel){
        .width = 16,
        .height = 6,
        .bytesperline = 32,
        .fourcc = V4L2_PIX_FMT_Z16,
        .rate = {1, 30},
        .stamp_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE,
        .bed = umockdev_testbed_new(),
        .context = g_main_context_new(),
    };
    g_main_context_push_thread_default(kernel.context);
    kernel.base = umockdev_ioctl_base_new();
    g_signal_connect(kernel.base, "handle-ioctl", G_CALLBACK(kernel_ioctl), NULL);
    umockdev_testbed_add_from_string(
        kernel.bed, "P: /devices/pci0000:00/0000:00:14.0\nE: SUBSYSTEM=pci\n\n", NULL);
    g_main_context_pop_thread_default(kernel.context);
    return pthread_create(&kernel.thread, NULL, kernel_run, NULL);
}

static int kernel_tear_down(void **state)
{
    char path[64];

    (void)state;
    for (unsigned k = 0; k < kernel.n_nodes; k++) {
        snprintf(path, sizeof(path), "/dev/%s", kernel.nodes[k].name);
        umockdev_testbed_detach_ioctl(kernel.bed, path, NULL);
    }
    __atomic_store_n(&kernel.quit, true, __ATOMIC_RELEASE);
    g_main_context_wakeup(kernel.context);
    pthread_join(kernel.thread, NULL);
    if (kernel.memory)
        munmap(kernel.memory, (size_t)KERNEL_BUFFERS * KERNEL_ROOM);
    g_object_unref(kernel.base);
    g_object_unref(kernel.bed);
    g_main_context_unref(kernel.context);
    return 0;
}

#define KERNEL_CAPTURE (V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING)

/* A new script, from its first step on. */
#define KERNEL_SCRIPT(...)                                                                         \
    do {                                                                                           \
        const enum kernel_step steps_[] = {__VA_ARGS__, STEP_NONE};                                \
        memcpy(kernel.script, steps_, sizeof(steps_));                                             \
        kernel.at = 0;                                                                             \
    } while (0)

/* Descriptors of this process; umockdev's sockets come and go as its thread gets to them. */
static inline unsigned kernel_n_descriptors(void)
{
    DIR *dir = opendir("/proc/self/fd");
    const struct dirent *entry;
    unsigned n = 0;

    assert_non_null(dir);
    while ((entry = readdir(dir))) {
        char path[300], target[64] = "";

        snprintf(path, sizeof(path), "/proc/self/fd/%s", entry->d_name);
        n += readlink(path, target, sizeof(target) - 1) > 0 && strncmp(target, "socket:", 7) != 0;
    }
    closedir(dir);
    return n;
}

/* Mappings of nodes in this process. */
static inline unsigned kernel_n_mappings(void)
{
    FILE *maps = fopen("/proc/self/maps", "r");
    char line[512];
    unsigned n = 0;

    assert_non_null(maps);
    while (fgets(line, sizeof(line), maps))
        n += strstr(line, "/dev/") && strstr(line, "video");
    fclose(maps);
    return n;
}

#endif
