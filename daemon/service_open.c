/* Opening beside the main thread. */
#include "daemon/service_open.h"

#include "daemon/clock.h"
#include "daemon/log.h"
#include "daemon/opening.h"
#include "daemon/service.h"

#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>

#define LOOK_NS  100000000u  /* between two looks for a signal */
#define GRACE_NS 1000000000u /* for a source to open when the service is to end */

/* On the heap: when it hangs, nobody frees what the thread has. */
struct start {
    const struct dx_config *config;
    const char *file;
    struct dx_pool *pool;
    struct dx_stream_list streams;
    struct dx_err err;
    int result;
    struct dx_opening opening;
    sem_t ended; /* everything above is written before it */
    pthread_t thread;
};

static void open_all(struct start *s)
{
    for (uint32_t k = 0; k < s->config->n_streams && s->result == 0; k++) {
        const struct dx_stream_config *c = &s->config->streams[k];
        struct dx_stream *stream;

        dx_opening_set(&s->opening, c);
        s->result = dx_stream_new(&stream, c, s->pool, &s->err);
        if (s->result == 0)
            dx_stream_list_add(&s->streams, stream);
        else
            dx_service_blame(&s->err, s->file, c);
    }
}

static void *start_main(void *start)
{
    struct start *s = start;

    open_all(s);
    sem_post(&s->ended);
    return NULL;
}

static bool is_to_end(void)
{
    sigset_t pending;

    return sigpending(&pending) == 0 &&
           (sigismember(&pending, SIGTERM) == 1 || sigismember(&pending, SIGINT) == 1);
}

/* False: the service is to end, and the thread does not. */
static bool await(struct start *s)
{
    uint64_t late_ns = dx_clock_ns() + DX_OPENING_LATE_NS, due_ns = UINT64_MAX;

    for (;;) {
        uint64_t now_ns = dx_clock_ns();

        if (dx_clock_sem_wait(&s->ended, now_ns + LOOK_NS) == 0)
            return true;
        if (due_ns == UINT64_MAX && is_to_end())
            due_ns = now_ns + GRACE_NS;
        if (now_ns < late_ns && now_ns < due_ns)
            continue;
        if (now_ns >= due_ns) {
            dx_log_warning("service", "stopping: stream %s: still being opened, not waited for",
                           dx_opening_get(&s->opening).text);
            return false;
        }
        dx_log_warning("service", "still opening stream %s", dx_opening_get(&s->opening).text);
        late_ns = UINT64_MAX; /* once */
    }
}

static int run(struct start *s)
{
    if (pthread_create(&s->thread, NULL, start_main, s) != 0) {
        open_all(s); /* not to be interrupted, but done */
        return 0;
    }
    pthread_setname_np(s->thread, "opener");
    if (!await(s))
        return DX_SERVICE_E_LEFT;
    pthread_join(s->thread, NULL); /* at once */
    return 0;
}

int dx_service_open(struct dx_stream_list *list, const struct dx_config *config, const char *file,
                    struct dx_pool *pool, struct dx_err *err)
{
    struct start *s = calloc(1, sizeof(*s));
    int r;

    if (!s)
        return dx_err_set(err, -ENOMEM, "%s", strerror(ENOMEM));
    s->config = config;
    s->file = file;
    s->pool = pool;
    dx_opening_init(&s->opening);
    sem_init(&s->ended, 0, 0);
    r = run(s);
    if (r == DX_SERVICE_E_LEFT)
        return r;
    *list = s->streams;
    if (s->result < 0)
        *err = s->err;
    r = s->result;
    sem_destroy(&s->ended);
    dx_opening_fini(&s->opening);
    free(s);
    return r;
}
