/* The daemon's clock: CLOCK_MONOTONIC in nanoseconds. Any thread. */
#ifndef DX_CLOCK_H
#define DX_CLOCK_H

#include <errno.h>
#include <semaphore.h>
#include <stdint.h>
#include <time.h>

static inline uint64_t dx_clock_ns(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

/* Waits for the semaphore, or until `due_ns` (0: for ever). 0, or -1: it did not come. */
static inline int dx_clock_sem_wait(sem_t *sem, uint64_t due_ns)
{
    struct timespec t = {(time_t)(due_ns / 1000000000u), (long)(due_ns % 1000000000u)};
    int r;

    do
        r = due_ns ? sem_clockwait(sem, CLOCK_MONOTONIC, &t) : sem_wait(sem);
    while (r < 0 && errno == EINTR);
    return r;
}

#endif
