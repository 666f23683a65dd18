/*
 * The metrics as a file. `next` is what the loop and the thread share: whoever exchanges a status
 * out of it owns it.
 */
#include "daemon/metrics_file.h"

#include "daemon/clock.h"
#include "daemon/log.h"
#include "daemon/metrics.h"
#include "daemon/status.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define MAX_PATH 4096
#define END_NS   500000000u /* for a write that is under way */

struct dx_metrics_file {
    char path[MAX_PATH], beside[MAX_PATH + 8];
    pthread_t thread;
    sem_t wake, done;
    atomic_bool stop;
    _Atomic(json_t *) next;

    /* the loop's */
    uint64_t period_ns, due_ns;

    /* the thread's */
    bool failing;
};

/* ---- the thread ------------------------------------------------------------------------------
 */

static int write_all(int fd, const char *text, size_t len)
{
    while (len) {
        ssize_t n = write(fd, text, len);

        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return n < 0 ? -errno : -EIO;
        text += n;
        len -= (size_t)n;
    }
    return 0;
}

/* Everybody may read it, whatever the umask: the collector is another user. */
static int replace_file(const struct dx_metrics_file *f, const char *text, size_t len)
{
    int fd = open(f->beside, O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0644);
    int r;

    if (fd < 0)
        return -errno;
    r = fchmod(fd, 0644) < 0 ? -errno : 0;
    if (r == 0)
        r = write_all(fd, text, len);
    if (close(fd) < 0 && r == 0)
        r = -errno;
    if (r == 0 && rename(f->beside, f->path) < 0)
        r = -errno;
    if (r < 0)
        unlink(f->beside);
    return r;
}

static int write_status(const struct dx_metrics_file *f, const json_t *status)
{
    char *text = NULL;
    size_t len = 0;
    FILE *out = open_memstream(&text, &len);
    int r;

    if (!out)
        return -ENOMEM;
    dx_metrics_print(out, status, DX_METRICS_PROMETHEUS);
    r = fclose(out) != 0 ? -ENOMEM : replace_file(f, text, len);
    free(text);
    return r;
}

/* What goes wrong is told once, until it goes well. */
static void tell(struct dx_metrics_file *f, int r)
{
    if (r < 0 && !f->failing)
        dx_log_error("metrics", "%s: %s; it is tried again", f->path, strerror(-r));
    else if (r == 0 && f->failing)
        dx_log_info("metrics", "%s: it is written again", f->path);
    f->failing = r < 0;
}

static void *run(void *file)
{
    struct dx_metrics_file *f = file;

    while (!atomic_load_explicit(&f->stop, memory_order_acquire)) {
        json_t *status;

        dx_clock_sem_wait(&f->wake, 0);
        status = atomic_exchange_explicit(&f->next, NULL, memory_order_acquire);
        if (status)
            tell(f, write_status(f, status));
        json_decref(status);
    }
    sem_post(&f->done);
    return NULL;
}

/* ---- the loop --------------------------------------------------------------------------------
 */

/* Is it one of ours? Or empty, as a full disk leaves it. */
static bool is_metrics(const char *path)
{
    static const char head[] = "# HELP dexeld_";
    char found[sizeof(head) - 1];
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    ssize_t n = fd < 0 ? -1 : read(fd, found, sizeof(found));

    if (fd >= 0)
        close(fd);
    return n == 0 || (n == (ssize_t)sizeof(found) && !memcmp(found, head, sizeof(found)));
}

/* Its file takes the place of what is there: of an older one, and of nothing else, whatever the
 * path is called. */
static int check_place(const char *path, struct dx_err *err)
{
    struct stat st;

    if (strlen(path) >= MAX_PATH)
        return dx_err_set(err, -ENAMETOOLONG, "metrics_file: a path of %zu bytes", strlen(path));
    if (stat(path, &st) < 0)
        return 0;
    if (!S_ISREG(st.st_mode))
        return dx_err_set(err, -EINVAL, "metrics_file: %s: found what is no regular file", path);
    if (!is_metrics(path))
        return dx_err_set(err, -EEXIST, "metrics_file: %s: found a file that has no metrics in it",
                          path);
    return 0;
}

int dx_metrics_file_new(struct dx_metrics_file **out, const char *path, uint32_t period_s,
                        struct dx_err *err)
{
    struct dx_metrics_file *f;
    int r = check_place(path, err);

    if (r)
        return r;
    f = calloc(1, sizeof(*f));
    if (!f)
        return dx_err_set(err, -ENOMEM, "no memory");
    snprintf(f->path, sizeof(f->path), "%s", path);
    snprintf(f->beside, sizeof(f->beside), "%s.new", path);
    f->period_ns = (uint64_t)period_s * 1000000000u;
    sem_init(&f->wake, 0, 0);
    sem_init(&f->done, 0, 0);
    r = pthread_create(&f->thread, NULL, run, f);
    if (r) {
        free(f);
        return dx_err_set(err, -r, "metrics_file: no thread: %s", strerror(r));
    }
    pthread_setname_np(f->thread, "metrics");
    *out = f;
    return 0;
}

void dx_metrics_file_free(struct dx_metrics_file *f)
{
    if (!f)
        return;
    atomic_store_explicit(&f->stop, true, memory_order_release);
    sem_post(&f->wake);
    if (dx_clock_sem_wait(&f->done, dx_clock_ns() + END_NS) < 0) {
        pthread_detach(f->thread); /* the disk is stuck: what the thread uses is left to it */
        return;
    }
    pthread_join(f->thread, NULL);
    json_decref(atomic_load_explicit(&f->next, memory_order_acquire));
    unlink(f->path);
    sem_destroy(&f->wake);
    sem_destroy(&f->done);
    free(f);
}

void dx_metrics_file_tick(struct dx_metrics_file *f, const struct dx_server *server,
                          uint64_t now_ns)
{
    if (!f || now_ns < f->due_ns)
        return;
    f->due_ns = now_ns + f->period_ns;
    /* the one before it, if the thread has not taken it; acq_rel: either side frees what the other
     * made */
    json_decref(atomic_exchange_explicit(&f->next, dx_status(server, true), memory_order_acq_rel));
    sem_post(&f->wake);
}
