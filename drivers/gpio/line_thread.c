/* Waiting for lines: ppoll on their descriptors, an eventfd, and a time. */
#include "drivers/gpio/line_thread.h"

#include "drivers/monotonic.h"

#include <errno.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <time.h>
#include <unistd.h>

#define NS 1000000000u

static void wait_for(struct dx_line_thread *t, uint64_t due_ns)
{
    struct pollfd polls[DX_GPIO_MAX_LINES + 1];
    int fds[DX_GPIO_MAX_LINES];
    size_t n = t->work.descriptors(t->work.ctx, fds);
    uint64_t now = dx_clock_ns(), left = due_ns > now ? due_ns - now : 0, count;
    const struct timespec time = {(time_t)(left / NS), (long)(left % NS)};

    for (size_t k = 0; k < n; k++)
        polls[k] = (struct pollfd){.fd = fds[k], .events = POLLIN};
    polls[n] = (struct pollfd){.fd = t->wake_fd, .events = POLLIN};
    (void)ppoll(polls, n + 1, due_ns == UINT64_MAX ? NULL : &time, NULL);
    (void)!read(t->wake_fd, &count, sizeof(count)); /* empty: EAGAIN */
}

static void *loop(void *arg)
{
    struct dx_line_thread *t = arg;

    while (!atomic_load_explicit(&t->stop, memory_order_acquire))
        wait_for(t, t->work.run(t->work.ctx, dx_clock_ns()));
    return NULL;
}

int dx_line_thread_start(struct dx_line_thread *t, const struct dx_line_work *work,
                         const char *name)
{
    int r;

    t->work = *work;
    atomic_init(&t->stop, false);
    t->wake_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (t->wake_fd < 0)
        return -errno;
    r = pthread_create(&t->thread, NULL, loop, t);
    if (r) {
        close(t->wake_fd);
        return -r;
    }
    pthread_setname_np(t->thread, name);
    t->runs = true;
    return 0;
}

void dx_line_thread_stop(struct dx_line_thread *t)
{
    if (!t->runs)
        return;
    atomic_store_explicit(&t->stop, true, memory_order_release);
    dx_line_thread_wake(t);
    pthread_join(t->thread, NULL);
    close(t->wake_fd);
    t->runs = false;
}

void dx_line_thread_wake(struct dx_line_thread *t)
{
    uint64_t one = 1;

    (void)!write(t->wake_fd, &one, sizeof(one));
}
