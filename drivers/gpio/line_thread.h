/*
 * A thread that waits for lines and for times: the kernel's queues are short, so events are taken
 * when they come, whatever the reader is at. One for each encoder and each rig; what it runs
 * guards its own data.
 */
#ifndef DX_LINE_THREAD_H
#define DX_LINE_THREAD_H

#include "drivers/gpio/gpio_port.h"

#include <pthread.h>
#include <stdatomic.h>

struct dx_line_work {
    void *ctx;
    /* Takes what has come and does what is due. Returns when it wants to be called again at the
     * latest (CLOCK_MONOTONIC); UINT64_MAX: when a line speaks. */
    uint64_t (*run)(void *ctx, uint64_t now_ns);
    /* What to wait for besides; asked after each run(). */
    size_t (*descriptors)(void *ctx, int fds[DX_GPIO_MAX_LINES]);
};

struct dx_line_thread {
    struct dx_line_work work;
    pthread_t thread;
    int wake_fd;
    _Atomic bool stop; /* written by the owner, before it wakes the thread */
    bool runs;
};

/* -ENOMEM, -EMFILE, -EAGAIN. A zeroed one can be stopped. */
int dx_line_thread_start(struct dx_line_thread *t, const struct dx_line_work *work,
                         const char *name);
/* Waits for its end: at most as long as one run() takes. */
void dx_line_thread_stop(struct dx_line_thread *t);
/* Has run() called soon. Any thread. */
void dx_line_thread_wake(struct dx_line_thread *t);

#endif
