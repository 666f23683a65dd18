/*
 * A stay of a camera: waiting for frames, and what becomes of everything else that can come of a
 * wait (docs/drivers/v4l2.md has the table). Owned by the reader thread; wake() from any.
 */
#ifndef DX_V4L2_STREAM_H
#define DX_V4L2_STREAM_H

#include "drivers/v4l2/v4l2_capture.h"

#define DX_V4L2_MAX_FAILURES 3 /* in so long: the camera is opened anew */
#define DX_V4L2_FAILURES_NS  10000000000u
#define DX_V4L2_MAX_EARLY    4        /* frames that wait for one made before them */
#define DX_V4L2_EARLY_NS     50000000 /* so long */

struct dx_v4l2_stream {
    struct dx_v4l2_capture capture;
    struct dx_v4l2_config config; /* without its texts */
    int wake_fd;
    bool on;
    bool gone; /* unplugged */
    int held;  /* the buffer that the reader has; -1: none */
    bool counts;
    uint32_t next_sequence; /* expected, where it `counts` */
    /* Dequeued, by their sequences: uvcvideo can give frames out of order on a busy machine, for it
     * fills buffers by several workers. */
    struct dx_v4l2_filled early[DX_V4L2_MAX_EARLY];
    unsigned n_early;
    uint64_t early_until_ns;                   /* then they are waited for no more */
    bool poll_failed;                          /* the last wait told of an error alone */
    uint64_t failure_ns[DX_V4L2_MAX_FAILURES]; /* newest last */
    uint64_t n_blocks, n_lost, n_damaged, n_restarts;
};

/* Nothing is open: can be closed, and woken. */
int dx_v4l2_stream_init(struct dx_v4l2_stream *s, const struct dx_v4l2_config *config,
                        struct dx_err *err);
/* Opens a node, settles its format and maps buffers. */
int dx_v4l2_stream_open(struct dx_v4l2_stream *s, const char *node, struct dx_err *err);
void dx_v4l2_stream_close(struct dx_v4l2_stream *s);

/* As dx_driver's. */
int dx_v4l2_stream_start(struct dx_v4l2_stream *s, struct dx_err *err);
int dx_v4l2_stream_read(struct dx_v4l2_stream *s, struct dx_block *block, struct dx_err *err);
void dx_v4l2_stream_stop(struct dx_v4l2_stream *s);
void dx_v4l2_stream_wake(struct dx_v4l2_stream *s);

#endif
