/*
 * The monotonic clock, by which drivers and service time and stamp: CLOCK_MONOTONIC. It is that of
 * the kernel's own stamps, and goes on over steps of the time of day. Any thread.
 */
#ifndef DX_MONOTONIC_H
#define DX_MONOTONIC_H

#include <stdint.h>
#include <time.h>

static inline uint64_t dx_clock_ns(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

static inline int64_t dx_clock_ms(void)
{
    return (int64_t)(dx_clock_ns() / 1000000);
}

#endif
