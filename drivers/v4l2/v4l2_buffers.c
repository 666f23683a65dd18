/* The buffers of a camera: mapped, queued, dequeued. */
#include "drivers/v4l2/v4l2_capture_priv.h"

#include <linux/videodev2.h>

#include <errno.h>
#include <string.h>
#include <sys/mman.h>

#define NS_PER_S  1000000000u
#define NS_PER_US 1000u

/* What QUERYBUF, QBUF and DQBUF take; `plane` is where the multi-planar ones have their facts. */
static struct v4l2_buffer buffer_of(const struct dx_v4l2_capture *c, unsigned index,
                                    struct v4l2_plane plane[VIDEO_MAX_PLANES])
{
    struct v4l2_buffer b = {.index = index, .type = dx_v4l2_type(c), .memory = V4L2_MEMORY_MMAP};

    memset(plane, 0, VIDEO_MAX_PLANES * sizeof(*plane));
    if (c->planar) {
        b.m.planes = plane;
        b.length = VIDEO_MAX_PLANES;
    }
    return b;
}

static int request(struct dx_v4l2_capture *c, unsigned n, unsigned *got)
{
    struct v4l2_requestbuffers r = {
        .count = n, .type = dx_v4l2_type(c), .memory = V4L2_MEMORY_MMAP};
    int rc = dx_v4l2_call(c, VIDIOC_REQBUFS, &r);

    *got = r.count;
    return rc;
}

/* A page of ours, and the buffer right behind it. */
static int map_one(struct dx_v4l2_capture *c, unsigned index, struct dx_err *err)
{
    struct dx_v4l2_buffer *buffer = &c->buffer[index];
    struct v4l2_plane plane[VIDEO_MAX_PLANES];
    struct v4l2_buffer b = buffer_of(c, index, plane);
    int r = dx_v4l2_call(c, VIDIOC_QUERYBUF, &b);
    size_t offset;
    void *room, *mapped;

    if (r)
        return dx_v4l2_failed(c, r, "VIDIOC_QUERYBUF", err);
    buffer->len = c->planar ? plane[0].length : b.length;
    offset = c->planar ? plane[0].m.mem_offset : b.m.offset;
    buffer->room_len = c->page_len + buffer->len;
    room = mmap(NULL, buffer->room_len, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (room == MAP_FAILED)
        return dx_v4l2_failed(c, -errno, "room for a buffer", err);
    buffer->room = room;
    mapped = mmap(buffer->room + c->page_len, buffer->len, PROT_READ | PROT_WRITE,
                  MAP_SHARED | MAP_FIXED, c->fd, (off_t)offset);
    return mapped == MAP_FAILED ? dx_v4l2_failed(c, -errno, "mapping a buffer", err) : 0;
}

/* The more there are, the longer a busy machine may keep the reader from its frames. */
static uint32_t n_wanted(const struct dx_v4l2_capture *c)
{
    uint64_t n = DX_V4L2_MEMORY / ((uint64_t)c->shape.bytesperline * c->shape.height + 1);

    if (n > DX_V4L2_MANY)
        return DX_V4L2_MANY;
    return n > DX_V4L2_N_BUFFERS ? (uint32_t)n : DX_V4L2_N_BUFFERS;
}

int dx_v4l2_capture_map(struct dx_v4l2_capture *c, struct dx_err *err)
{
    struct dx_v4l2_layout layout;
    unsigned n = 0;
    char why[96];
    int r = request(c, n_wanted(c), &n);

    if (r)
        return dx_v4l2_failed(c, r, "VIDIOC_REQBUFS", err);
    c->n_buffers = n < DX_V4L2_MAX_BUFFERS ? n : DX_V4L2_MAX_BUFFERS;
    if (n < 2)
        return dx_err_set(err, -ENOMEM, "%s: gives %u buffers, expected 2 or more", c->node, n);
    dx_v4l2_layout(&layout, &c->shape, why);
    for (unsigned k = 0; k < c->n_buffers; k++) {
        r = map_one(c, k, err);
        if (r)
            return r;
        if (c->buffer[k].len < layout.end)
            return dx_err_set(err, -EINVAL, "%s: buffer of %zu bytes, expected %zu or more",
                              c->node, c->buffer[k].len, layout.end);
    }
    return 0;
}

void dx_v4l2_capture_unmap(struct dx_v4l2_capture *c)
{
    unsigned none;

    for (unsigned k = 0; k < c->n_buffers; k++) {
        if (c->buffer[k].room)
            munmap(c->buffer[k].room, c->buffer[k].room_len);
        c->buffer[k] = (struct dx_v4l2_buffer){NULL, 0, 0};
    }
    if (c->n_buffers && c->fd >= 0)
        (void)request(c, 0, &none);
    c->n_buffers = 0;
}

/* ---- streaming ----------------------------------------------------------------------------------
 */

int dx_v4l2_capture_queue(struct dx_v4l2_capture *c, unsigned index, struct dx_err *err)
{
    struct v4l2_plane plane[VIDEO_MAX_PLANES];
    struct v4l2_buffer b = buffer_of(c, index, plane);
    int r;

    if (c->planar)
        b.length = 1;
    r = dx_v4l2_call(c, VIDIOC_QBUF, &b);
    return r ? dx_v4l2_failed(c, r, "VIDIOC_QBUF", err) : 0;
}

int dx_v4l2_capture_on(struct dx_v4l2_capture *c, struct dx_err *err)
{
    int type = (int)dx_v4l2_type(c), r = 0;

    for (unsigned k = 0; k < c->n_buffers && r == 0; k++)
        r = dx_v4l2_capture_queue(c, k, err);
    if (r == 0) {
        r = dx_v4l2_call(c, VIDIOC_STREAMON, &type);
        if (r == 0)
            return 0;
        r = dx_v4l2_failed(c, r, "VIDIOC_STREAMON", err);
    }
    (void)dx_v4l2_call(c, VIDIOC_STREAMOFF, &type); /* what was queued comes back */
    return r;
}

int dx_v4l2_capture_off(struct dx_v4l2_capture *c, struct dx_err *err)
{
    int type = (int)dx_v4l2_type(c), r = dx_v4l2_call(c, VIDIOC_STREAMOFF, &type);

    return r ? dx_v4l2_failed(c, r, "VIDIOC_STREAMOFF", err) : 0;
}

int dx_v4l2_capture_dequeue(struct dx_v4l2_capture *c, struct dx_v4l2_filled *filled,
                            struct dx_err *err)
{
    struct v4l2_plane plane[VIDEO_MAX_PLANES];
    struct v4l2_buffer b = buffer_of(c, 0, plane);
    int r = dx_v4l2_call(c, VIDIOC_DQBUF, &b);

    if (r == -EAGAIN)
        return r;
    if (r)
        return dx_v4l2_failed(c, r, "VIDIOC_DQBUF", err);
    if (b.index >= c->n_buffers)
        return dx_err_set(err, -EPROTO, "%s: filled buffer %u, there are %u", c->node, b.index,
                          c->n_buffers);
    *filled = (struct dx_v4l2_filled){
        .index = b.index,
        .len = c->planar ? plane[0].bytesused : b.bytesused,
        .data_offset = c->planar ? plane[0].data_offset : 0,
        .sequence = b.sequence,
        .flags = b.flags,
        .stamp_ns =
            (uint64_t)b.timestamp.tv_sec * NS_PER_S + (uint64_t)b.timestamp.tv_usec * NS_PER_US,
    };
    return 0;
}

uint8_t *dx_v4l2_capture_block(struct dx_v4l2_capture *c, const struct dx_v4l2_filled *filled)
{
    uint8_t *bytes = c->buffer[filled->index].room + c->page_len - DX_V4L2_HEADER_LEN;
    const struct dx_v4l2_header h = {c->shape, filled->data_offset, filled->sequence,
                                     filled->flags};

    dx_v4l2_header_put(bytes, &h);
    return bytes;
}
