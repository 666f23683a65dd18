/* The daemon's clock (drivers/monotonic.h), and waiting by it. Any thread. */
#ifndef DX_CLOCK_H
#define DX_CLOCK_H

#include "drivers/monotonic.h"

#include <errno.h>
#include <semaphore.h>

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
