/*
 * A camera's node: format, buffers, streaming; one system call after the other, no policy. Owned by
 * the reader thread (a probe opens its own).
 *
 * Buffers are mapped behind a page of ours, so that a block's header and the camera's bytes lie one
 * after the other and nothing is copied: [..... header | buffer as the driver fills it].
 *
 * What fails returns negative errno with err, or DX_DRIVER_E_GONE when the camera is no longer
 * there.
 */
#ifndef DX_V4L2_CAPTURE_H
#define DX_V4L2_CAPTURE_H

#include "drivers/v4l2/v4l2_block.h"

#define DX_V4L2_N_BUFFERS   6         /* asked for at the least ... */
#define DX_V4L2_MANY        16        /* ... and at the most, half a second of frames, ... */
#define DX_V4L2_MEMORY      (8 << 20) /* ... while they are of so many bytes together */
#define DX_V4L2_MAX_BUFFERS 32

struct dx_v4l2_buffer {
    uint8_t *room; /* our page, then the buffer; NULL: not mapped */
    size_t room_len, len;
};

struct dx_v4l2_capture {
    int fd; /* -1: closed */
    char node[80], card[33], bus[33];
    bool planar; /* the multi-planar calls; one plane of memory all the same */
    struct dx_v4l2_shape shape;
    double fps; /* 0: not told */
    size_t page_len;
    unsigned n_buffers;
    struct dx_v4l2_buffer buffer[DX_V4L2_MAX_BUFFERS];
};

/* A buffer that was dequeued. */
struct dx_v4l2_filled {
    unsigned index;
    size_t len; /* bytes used, of what lies before the image too */
    uint32_t data_offset, sequence, flags;
    uint64_t stamp_ns;
};

/* Opens a node that can capture and stream. -ENOTSUP: it cannot. */
int dx_v4l2_capture_open(struct dx_v4l2_capture *c, const char *node, struct dx_err *err);
/* NULL-safe in all its parts; leaves `fd` -1. */
void dx_v4l2_capture_close(struct dx_v4l2_capture *c);

/* Settles which format AUTO is: one that is surely depth. -ENOTSUP: it has not the wanted one. */
int dx_v4l2_capture_has(const struct dx_v4l2_capture *c, enum dx_v4l2_format *format,
                        struct dx_err *err);
/* The size that it has now; 0x0 when it does not say. */
void dx_v4l2_capture_size(const struct dx_v4l2_capture *c, uint32_t *width, uint32_t *height);

/* Sets format, size and rate, and maps buffers. */
int dx_v4l2_capture_prepare(struct dx_v4l2_capture *c, const struct dx_v4l2_config *config,
                            struct dx_err *err);
/* Gives the buffers back; also of a camera that is gone. */
void dx_v4l2_capture_unmap(struct dx_v4l2_capture *c);

/* Queues all buffers, and streams. */
int dx_v4l2_capture_on(struct dx_v4l2_capture *c, struct dx_err *err);
/* All buffers are ours again. */
int dx_v4l2_capture_off(struct dx_v4l2_capture *c, struct dx_err *err);
int dx_v4l2_capture_queue(struct dx_v4l2_capture *c, unsigned index, struct dx_err *err);
/* -EAGAIN: nothing ready; other errors as they come. */
int dx_v4l2_capture_dequeue(struct dx_v4l2_capture *c, struct dx_v4l2_filled *filled,
                            struct dx_err *err);

/* What has happened, one at a time. */
enum dx_v4l2_event {
    DX_V4L2_NO_EVENT,
    DX_V4L2_SOURCE_CHANGED,
    DX_V4L2_STREAM_ENDED,
    DX_V4L2_OTHER_EVENT,
};
enum dx_v4l2_event dx_v4l2_capture_event(struct dx_v4l2_capture *c);

/* The bytes of a block: puts the header before a buffer. */
uint8_t *dx_v4l2_capture_block(struct dx_v4l2_capture *c, const struct dx_v4l2_filled *filled);

#endif
