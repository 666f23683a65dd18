/*
 * Waits that run out take a twentieth of their time, and CLOCK_MONOTONIC goes on as if they had
 * taken all of it: for tests of back-offs and of answers that never come. What does come ends a
 * wait as ever. By the linker's wraps (FAST_WAITS in the Makefile); any thread.
 */

#include <poll.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdint.h>
#include <time.h>

#define SHARE 20

int __real_ppoll(struct pollfd *fd, nfds_t n, const struct timespec *t, const sigset_t *mask);
int __wrap_ppoll(struct pollfd *fd, nfds_t n, const struct timespec *t, const sigset_t *mask);
int __wrap_poll(struct pollfd *fd, nfds_t n, int timeout_ms);
int __real_nanosleep(const struct timespec *t, struct timespec *left);
int __wrap_nanosleep(const struct timespec *t, struct timespec *left);
int __real_clock_gettime(clockid_t id, struct timespec *t);
int __wrap_clock_gettime(clockid_t id, struct timespec *t);

static _Atomic int64_t ahead_ns; /* of the clock */

static int64_t ns_of(const struct timespec *t)
{
    return (int64_t)t->tv_sec * 1000000000 + t->tv_nsec;
}

static struct timespec time_of(int64_t ns)
{
    return (struct timespec){ns / 1000000000, ns % 1000000000};
}

static void run_ahead(int64_t whole_ns)
{
    atomic_fetch_add(&ahead_ns, whole_ns - whole_ns / SHARE);
}

int __wrap_ppoll(struct pollfd *fd, nfds_t n, const struct timespec *t, const sigset_t *mask)
{
    struct timespec part;
    int r;

    if (!t)
        return __real_ppoll(fd, n, t, mask);
    part = time_of(ns_of(t) / SHARE);
    r = __real_ppoll(fd, n, &part, mask);
    if (r == 0)
        run_ahead(ns_of(t));
    return r;
}

int __wrap_poll(struct pollfd *fd, nfds_t n, int timeout_ms)
{
    const struct timespec t = time_of((int64_t)timeout_ms * 1000000);

    return __wrap_ppoll(fd, n, timeout_ms < 0 ? NULL : &t, NULL);
}

int __wrap_nanosleep(const struct timespec *t, struct timespec *left)
{
    const struct timespec part = time_of(ns_of(t) / SHARE);
    int r = __real_nanosleep(&part, left);

    run_ahead(ns_of(t));
    return r;
}

int __wrap_clock_gettime(clockid_t id, struct timespec *t)
{
    int r = __real_clock_gettime(id, t);

    if (r == 0 && id == CLOCK_MONOTONIC)
        *t = time_of(ns_of(t) + atomic_load(&ahead_ns));
    return r;
}
