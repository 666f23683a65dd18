/*
 * Work that the loop must not wait for: a function runs in a thread of its own, and when it has
 * ended another runs on the loop thread. One at a time. What the first has written the second may
 * read, and the other way round with the next work: starting and joining the thread order it.
 */
#ifndef DX_ASIDE_H
#define DX_ASIDE_H

#include <pthread.h>
#include <semaphore.h>
#include <stdbool.h>
#include <stdint.h>
#include <systemd/sd-event.h>

struct dx_aside {
    void (*work)(void *ctx);
    void (*done)(void *ctx);
    void *ctx;
    int fd; /* eventfd, raised when the work has ended */
    sd_event_source *source;
    sem_t ended;
    pthread_t thread;
    bool has_thread; /* not joined yet */
    bool is_under_way;
};

/* -errno; then there is nothing to end. */
int dx_aside_init(struct dx_aside *a, sd_event *event, void *ctx);

/* Nothing is under way, or `done` has been called. `work` in a thread called `name`, then `done` on
 * the loop. When there is no thread to be had the work is done here and now: late, but done. */
void dx_aside_start(struct dx_aside *a, const char *name, void (*work)(void *ctx),
                    void (*done)(void *ctx));

/* When the loop runs no more: waits for the work, without `done`. False: it did not end before
 * `due_ns` of CLOCK_MONOTONIC; what it uses must stay. */
bool dx_aside_wait(struct dx_aside *a, uint64_t due_ns);

/* Nothing is under way. The loop may be gone. */
void dx_aside_fini(struct dx_aside *a);

#endif
