/* The monotonic clock, for durations and for stamps of services on this machine. */
#ifndef DX_NOW_H
#define DX_NOW_H

#include <stdint.h>
#include <time.h>

static inline uint64_t dx_now_ns(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

/* Seconds since a dx_now_ns(). */
static inline double dx_seconds_since(uint64_t start_ns)
{
    return (double)(dx_now_ns() - start_ns) * 1e-9;
}

/* What all threads of this process have spent on processors: what others do on the machine touches
 * it little. */
static inline uint64_t dx_cpu_ns(void)
{
    struct timespec t;

    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

#endif
