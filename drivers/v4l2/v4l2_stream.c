/* Reading frames of a camera, and its errors. */
#include "drivers/v4l2/v4l2_stream.h"

#include "drivers/monotonic.h"

#include <linux/videodev2.h>

#include <errno.h>
#include <poll.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#define WAIT_MS     100
#define NS_PER_HOUR 3600000000000u

int dx_v4l2_stream_init(struct dx_v4l2_stream *s, const struct dx_v4l2_config *config,
                        struct dx_err *err)
{
    *s = (struct dx_v4l2_stream){.config = *config, .held = -1};
    s->config.path = s->config.serial = s->config.port = NULL; /* the caller's memory */
    s->capture.fd = -1;
    s->wake_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (s->wake_fd < 0)
        return dx_err_set(err, -errno, "v4l2: eventfd: %s", strerror(errno));
    return 0;
}

int dx_v4l2_stream_open(struct dx_v4l2_stream *s, const char *node, struct dx_err *err)
{
    int r = dx_v4l2_capture_open(&s->capture, node, err);

    if (r == 0)
        r = dx_v4l2_capture_prepare(&s->capture, &s->config, err);
    s->gone = r == DX_DRIVER_E_GONE;
    return r;
}

void dx_v4l2_stream_close(struct dx_v4l2_stream *s)
{
    dx_v4l2_stream_stop(s);
    dx_v4l2_capture_close(&s->capture);
    if (s->wake_fd >= 0)
        close(s->wake_fd);
    s->wake_fd = -1;
}

int dx_v4l2_stream_start(struct dx_v4l2_stream *s, struct dx_err *err)
{
    int r = dx_v4l2_capture_on(&s->capture, err);

    s->on = r == 0;
    s->gone |= r == DX_DRIVER_E_GONE;
    s->held = -1;
    s->n_early = 0;
    s->counts = false;
    s->poll_failed = false;
    return r;
}

void dx_v4l2_stream_stop(struct dx_v4l2_stream *s)
{
    if (s->on)
        (void)dx_v4l2_capture_off(&s->capture, NULL);
    s->on = false;
    s->held = -1;
    s->n_early = 0;
}

void dx_v4l2_stream_wake(struct dx_v4l2_stream *s)
{
    uint64_t one = 1;

    (void)!write(s->wake_fd, &one, sizeof(one));
}

/* ---- what goes wrong ----------------------------------------------------------------------------
 */

/* Takes all buffers back and streams anew. When that had to be done too often, it does not help:
 * `code`, so that the camera is opened anew. */
static int restart(struct dx_v4l2_stream *s, int code, const char *why, struct dx_err *err)
{
    uint64_t now = dx_clock_ns(), first = s->failure_ns[1];
    int r;

    memmove(s->failure_ns, s->failure_ns + 1, sizeof(s->failure_ns) - sizeof(s->failure_ns[0]));
    s->failure_ns[DX_V4L2_MAX_FAILURES - 1] = now;
    if (first && now - first < DX_V4L2_FAILURES_NS)
        return dx_err_set(err, code, "%s: %s, %d times in %llu s", s->capture.node, why,
                          DX_V4L2_MAX_FAILURES, DX_V4L2_FAILURES_NS / 1000000000ull);
    s->n_restarts++;
    r = dx_v4l2_capture_off(&s->capture, err);
    if (r == 0)
        r = dx_v4l2_stream_start(s, err);
    return r ? r : DX_DRIVER_E_AGAIN;
}

/* The source has another format now, or says so. */
static int renegotiate(struct dx_v4l2_stream *s, struct dx_err *err)
{
    int r;

    dx_v4l2_stream_stop(s);
    dx_v4l2_capture_unmap(&s->capture);
    r = dx_v4l2_capture_prepare(&s->capture, &s->config, err);
    if (r == 0)
        r = dx_v4l2_stream_start(s, err);
    return r ? r : DX_DRIVER_E_AGAIN;
}

/* 0: nothing that matters. */
static int take_events(struct dx_v4l2_stream *s, struct dx_err *err)
{
    bool changed = false;
    enum dx_v4l2_event e;

    while ((e = dx_v4l2_capture_event(&s->capture)) != DX_V4L2_NO_EVENT) {
        if (e == DX_V4L2_STREAM_ENDED)
            return dx_err_set(err, -EPIPE, "%s: has ended its stream", s->capture.node);
        changed |= e == DX_V4L2_SOURCE_CHANGED;
    }
    return changed ? renegotiate(s, err) : 0;
}

/* No buffer was queued, or the queue is broken. The first is cured by now: the reader's was given
 * back before the wait. */
static int poll_failed(struct dx_v4l2_stream *s, struct dx_err *err)
{
    bool again = s->poll_failed;

    s->poll_failed = !again;
    return again ? restart(s, -EIO, "poll tells of an error", err) : DX_DRIVER_E_AGAIN;
}

static int dequeue_failed(struct dx_v4l2_stream *s, int code, struct dx_err *err)
{
    switch (code) {
    case -EAGAIN:
        return DX_DRIVER_E_AGAIN;
    case -EIO:
        return restart(s, code, "input/output error", err);
    case -EPIPE:
        return dx_err_set(err, code, "%s: has ended its stream", s->capture.node);
    default: /* lost its state, or is gone */
        return code;
    }
}

/* ---- frames -------------------------------------------------------------------------------------
 */

/* Sequences count what the camera made; they begin anew with the stream. */
static void count_lost(struct dx_v4l2_stream *s, uint32_t sequence)
{
    uint32_t ahead = sequence - s->next_sequence;

    if (s->counts && ahead < UINT32_MAX / 2)
        s->n_lost += ahead;
    s->counts = true;
    s->next_sequence = sequence + 1;
}

static bool is_whole(const struct dx_v4l2_capture *c, const struct dx_v4l2_filled *f)
{
    struct dx_v4l2_layout layout;
    char why[96];

    return !(f->flags & V4L2_BUF_FLAG_ERROR) && !dx_v4l2_layout(&layout, &c->shape, why) &&
           f->len <= c->buffer[f->index].len && f->data_offset <= f->len &&
           f->len - f->data_offset >= layout.end;
}

static enum dx_clock clock_of(const struct dx_v4l2_filled *f, uint64_t now)
{
    if ((f->flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC)
        return f->stamp_ns ? DX_CLOCK_DEVICE : DX_CLOCK_NONE;
    /* uvcvideo flags its stamps so even where it was told to take them from the other clock */
    return f->stamp_ns > now + NS_PER_HOUR ? DX_CLOCK_REALTIME : DX_CLOCK_MONOTONIC;
}

/* The one whose turn it would have been is counted as lost already. Only as many can be late as
 * there are buffers: a camera may begin to count anew. */
static bool is_late(const struct dx_v4l2_stream *s, uint32_t sequence)
{
    return s->counts && s->next_sequence - sequence - 1 < s->capture.n_buffers;
}

/* The first of the early ones: nothing is missing before it, or is waited for any more. */
static bool is_due(const struct dx_v4l2_stream *s)
{
    return s->n_early &&
           (!s->counts || s->early[0].sequence == s->next_sequence ||
            s->n_early == DX_V4L2_MAX_EARLY || s->n_early >= s->capture.n_buffers / 2 ||
            dx_clock_ns() >= s->early_until_ns);
}

static void put_in_order(struct dx_v4l2_stream *s, const struct dx_v4l2_filled *f)
{
    unsigned k = s->n_early++;

    if (k == 0)
        s->early_until_ns = dx_clock_ns() + DX_V4L2_EARLY_NS;
    for (; k > 0 && s->early[k - 1].sequence - f->sequence < UINT32_MAX / 2; k--)
        s->early[k] = s->early[k - 1];
    s->early[k] = *f;
}

static int take_first(struct dx_v4l2_stream *s, struct dx_block *block, struct dx_err *err)
{
    struct dx_v4l2_filled f = s->early[0];
    uint64_t now = dx_clock_ns();
    int r;

    s->n_early--;
    memmove(s->early, s->early + 1, s->n_early * sizeof(s->early[0]));
    count_lost(s, f.sequence);
    if (!is_whole(&s->capture, &f)) {
        s->n_damaged++;
        r = dx_v4l2_capture_queue(&s->capture, f.index, err);
        return r ? r : DX_DRIVER_E_AGAIN;
    }
    s->held = (int)f.index;
    *block = (struct dx_block){
        .bytes = dx_v4l2_capture_block(&s->capture, &f),
        .len = DX_V4L2_HEADER_LEN + f.len,
        .stamp = {now, f.stamp_ns, clock_of(&f, now)},
        .number = s->n_blocks,
        .first = s->n_blocks == 0,
        .source = s->capture.node,
    };
    s->n_blocks++;
    return 0;
}

static int take_frame(struct dx_v4l2_stream *s, struct dx_block *block, struct dx_err *err)
{
    struct dx_v4l2_filled f;
    int r = dx_v4l2_capture_dequeue(&s->capture, &f, err);

    if (r)
        return dequeue_failed(s, r, err);
    s->poll_failed = false;
    if (is_late(s, f.sequence)) {
        r = dx_v4l2_capture_queue(&s->capture, f.index, err);
        return r ? r : DX_DRIVER_E_AGAIN;
    }
    put_in_order(s, &f);
    return is_due(s) ? take_first(s, block, err) : DX_DRIVER_E_AGAIN;
}

/* 0, AGAIN (woken, or nothing in time), or negative. */
static int wait_for(struct dx_v4l2_stream *s, short *events, struct dx_err *err)
{
    struct pollfd fd[2] = {
        {.fd = s->capture.fd, .events = POLLIN | POLLPRI | POLLERR},
        {.fd = s->wake_fd, .events = POLLIN},
    };
    uint64_t count;
    int n = poll(fd, 2, s->n_early ? (int)(DX_V4L2_EARLY_NS / 1000000) : WAIT_MS);

    if (n < 0 && errno != EINTR)
        return dx_err_set(err, -errno, "%s: poll: %s", s->capture.node, strerror(errno));
    if (n <= 0)
        return DX_DRIVER_E_AGAIN;
    if (fd[1].revents) {
        (void)!read(s->wake_fd, &count, sizeof(count));
        return DX_DRIVER_E_AGAIN;
    }
    *events = fd[0].revents;
    return 0;
}

static int read_or_fail(struct dx_v4l2_stream *s, struct dx_block *block, struct dx_err *err)
{
    short events = 0;
    int r = 0;

    if (s->held >= 0)
        r = dx_v4l2_capture_queue(&s->capture, (unsigned)s->held, err);
    s->held = -1;
    if (r)
        return r;
    if (is_due(s))
        return take_first(s, block, err);
    r = wait_for(s, &events, err);
    if (r)
        return r;
    if (events & POLLHUP)
        return dx_err_set(err, DX_DRIVER_E_GONE, "%s: unplugged", s->capture.node);
    if (events & POLLPRI)
        r = take_events(s, err);
    if (r)
        return r;
    if (events & POLLIN)
        return take_frame(s, block, err);
    return events & (POLLERR | POLLNVAL) ? poll_failed(s, err) : DX_DRIVER_E_AGAIN;
}

int dx_v4l2_stream_read(struct dx_v4l2_stream *s, struct dx_block *block, struct dx_err *err)
{
    int r = read_or_fail(s, block, err);

    s->gone |= r == DX_DRIVER_E_GONE;
    return r;
}
