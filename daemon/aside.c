/* A thread for one piece of work, and its end as an event of the loop. */
#include "daemon/aside.h"

#include "daemon/clock.h"

#include <errno.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <unistd.h>

static void *aside_main(void *aside)
{
    struct dx_aside *a = aside;
    uint64_t one = 1;
    ssize_t n;

    a->work(a->ctx);
    n = write(a->fd, &one, sizeof(one)); /* the counter is far from full */
    (void)n;
    sem_post(&a->ended);
    return NULL;
}

static void join(struct dx_aside *a)
{
    if (a->has_thread)
        pthread_join(a->thread, NULL); /* its last act is done: at once */
    a->has_thread = a->is_under_way = false;
}

static int on_end(sd_event_source *source, int fd, uint32_t revents, void *aside)
{
    struct dx_aside *a = aside;
    uint64_t n;

    (void)source;
    (void)revents;
    if (read(fd, &n, sizeof(n)) != sizeof(n) || !a->is_under_way)
        return 0;
    dx_clock_sem_wait(&a->ended, 0); /* raised, or just about to be */
    join(a);
    a->done(a->ctx);
    return 0;
}

int dx_aside_init(struct dx_aside *a, sd_event *event, void *ctx)
{
    int r;

    *a = (struct dx_aside){.ctx = ctx};
    a->fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    if (a->fd < 0)
        return -errno;
    r = sd_event_add_io(event, &a->source, a->fd, EPOLLIN, on_end, a);
    if (r < 0) {
        close(a->fd);
        return r;
    }
    sem_init(&a->ended, 0, 0);
    return 0;
}

void dx_aside_start(struct dx_aside *a, const char *name, void (*work)(void *ctx),
                    void (*done)(void *ctx))
{
    a->work = work;
    a->done = done;
    a->is_under_way = true;
    a->has_thread = pthread_create(&a->thread, NULL, aside_main, a) == 0;
    if (a->has_thread)
        pthread_setname_np(a->thread, name);
    else
        aside_main(a);
}

bool dx_aside_wait(struct dx_aside *a, uint64_t due_ns)
{
    if (!a->is_under_way)
        return true;
    if (dx_clock_sem_wait(&a->ended, due_ns) < 0)
        return false;
    join(a);
    return true;
}

void dx_aside_fini(struct dx_aside *a)
{
    sd_event_source_disable_unref(a->source);
    close(a->fd);
    sem_destroy(&a->ended);
}
