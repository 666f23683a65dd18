/*
 * tsc_khz: the rate of this processor's time stamp counter. An emulated guest reads the same
 * counter, and is told its rate (tsc_early_khz): measuring it, which takes it some milliseconds of
 * a host that may be busy, has made the guest's clock ten times too fast.
 */
#include <poll.h>
#include <stdint.h>
#include <stdio.h>
#include <time.h>
#include <x86intrin.h>

static uint64_t now_ns(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC_RAW, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

int main(void)
{
    uint64_t from_ns = now_ns(), from = __rdtsc();
    uint64_t ns, ticks;

    poll(NULL, 0, 200);
    ns = now_ns() - from_ns;
    ticks = __rdtsc() - from;
    printf("%.0f\n", (double)ticks / (double)ns * 1e6);
    return 0;
}
