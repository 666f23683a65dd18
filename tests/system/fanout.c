/*
 * fanout SOCKET PID: ten q16 subscribers of one stream. One never reads, one reads a byte at a
 * time, eight keep up. The eight miss no epoch; the slow one has whole meshes, the same as theirs;
 * the stuck one (its process id is printed) is thrown out; the service's memory stays what it was
 * after two seconds. Exits 77 when the machine was too busy for it to prove anything.
 */
#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "client/session.h"
#include "tests/system/follower.h"

#define N_FAST       8
#define WARM_EPOCHS  60    /* two seconds */
#define AFTER_EPOCHS 90    /* to go on after the stuck one is gone */
#define TURN_BYTES   10000 /* read by the slow one in an epoch: some milliseconds of work */
#define SLOW_EPOCHS  (SANITIZED ? 1u : 3u) /* that the slow one is to have */
/* Blocks of the arena are memory only once they were used: a pin more at an unlucky moment. What
 * leaked with each epoch would be ten times that. */
#define RSS_MORE_KIB 3072

/* A process of its own that subscribes and never reads. The pipe closes when it was thrown out. */
static pid_t start_stuck(const char *socket, int *gone)
{
    int ends[2];
    pid_t pid;

    if (pipe(ends) < 0 || (pid = fork()) < 0)
        die("stuck: %s", strerror(errno));
    if (pid == 0) {
        struct follower f = {.name = "stuck"};
        struct pollfd p;

        prctl(PR_SET_PDEATHSIG, SIGKILL);
        close(ends[0]);
        follower_open(&f, socket, NULL, DEXEL_Q16);
        p = (struct pollfd){dexel_fd(f.d), 0, 0};
        _exit(poll(&p, 1, -1) == 1 && (p.revents & POLLHUP) ? 0 : 1);
    }
    close(ends[1]);
    *gone = ends[0];
    return pid;
}

/* What came, byte by byte, each through the whole of libdexel; but no more than TURN_BYTES. */
static void slow_turn(struct follower *f)
{
    struct dx_connection *c = &f->d->connection;

    for (int k = 0; k < TURN_BYTES; k++) {
        if (c->in_pos == c->in_len)
            c->in_pos = c->in_len = 0;
        if (c->in_len == c->in_cap || read(c->fd, c->in + c->in_len, 1) != 1)
            return;
        c->in_len++;
        if (dx_session_dispatch(f->d) < 0)
            die("%s: %s", f->name, dexel_error(f->d));
    }
}

/* Every epoch that the slow one had, the reference had too, and held the same. */
static void compare(const struct follower *slow, const struct follower *reference)
{
    unsigned n_same = 0;

    for (unsigned k = 0; k < FOLLOWER_HISTORY; k++) {
        const struct follower_commit *c = &slow->history[k], *r;

        r = follower_at(reference, c->commit.epoch);
        if (!r)
            continue;
        if (r->digest != c->digest)
            die("epoch %llu: the slow one holds another mesh", (unsigned long long)c->commit.epoch);
        n_same++;
    }
    printf("slow: %u whole meshes in %u epochs, %u compared\n", slow->n_commits,
           reference->n_commits, n_same);
    if (n_same < SLOW_EPOCHS || slow->n_commits >= reference->n_commits)
        die("expected at least %u epochs of the slow one, and fewer than the others have",
            SLOW_EPOCHS);
}

/* ---- the witness ---------------------------------------------------------------------------- */

#define WITNESS_NS 5000000u  /* it wants to wake so often */
#define STALL_NS   20000000u /* and is later than this only on a machine that is too busy */

static _Atomic unsigned n_stalls;

static void *witness(void *unused)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    for (;;) {
        struct timespec now;
        int64_t late;

        t.tv_nsec += WITNESS_NS;
        t.tv_sec += t.tv_nsec / 1000000000;
        t.tv_nsec %= 1000000000;
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL);
        clock_gettime(CLOCK_MONOTONIC, &now);
        late = (int64_t)(now.tv_sec - t.tv_sec) * 1000000000 + (now.tv_nsec - t.tv_nsec);
        if (late > STALL_NS) {
            n_stalls++;
            t = now;
        }
    }
    return unused;
}

/* ---- judgement ------------------------------------------------------------------------------ */

/*
 * No epoch and no frame missing. A frame lasts 33 ms: when a thread that only sleeps was late by
 * most of that, the machine has no room for the test, and what is missing proves nothing: skipped.
 */
static bool kept_up(const struct follower *f)
{
    uint64_t frames = f->last.frame - f->first_frame + 1;
    uint64_t dropped = f->last.n_dropped - f->first_dropped;

    printf("%s: %u epochs, %llu frames, %llu of them dropped by the mesher, missed %u, reset %u\n",
           f->name, f->n_commits - 1, (unsigned long long)frames, (unsigned long long)dropped,
           f->n_missed, f->n_resets);
    return !f->n_resets && !f->n_missed && !dropped && frames == f->n_commits - 1;
}

int main(int argc, char **argv)
{
    static struct follower fast[N_FAST], slow = {.name = "slow"};
    static char names[N_FAST][8];
    struct follower *all[N_FAST];
    long pid = argc == 3 ? strtol(argv[2], NULL, 10) : 0, rss = 0, most = 0;
    unsigned until = 0;
    uint64_t seen = 0;
    pthread_t thread;
    bool good = true;
    int gone, status;
    pid_t stuck;

    if (pid <= 0)
        die("usage: fanout SOCKET PID");
    if (pthread_create(&thread, NULL, witness, NULL) != 0)
        die("no thread");
    stuck = start_stuck(argv[1], &gone);
    follower_open(&slow, argv[1], NULL, DEXEL_Q16);
    for (unsigned k = 0; k < N_FAST; k++) {
        snprintf(names[k], sizeof(names[k]), "fast %u", k);
        fast[k] = (struct follower){.name = names[k], .raw = k > 0};
        all[k] = &fast[k];
        follower_open(&fast[k], argv[1], NULL, DEXEL_Q16);
    }
    while (!until || fast[0].n_commits < until || slow.n_commits < SLOW_EPOCHS) {
        if (fast[0].n_commits == FOLLOWER_HISTORY)
            die("the slow one has %u epochs of %d", slow.n_commits, FOLLOWER_HISTORY);
        if (followers_turn(all, N_FAST, gone) && gone >= 0) {
            close(gone);
            gone = -1;
            until = fast[0].n_commits + AFTER_EPOCHS;
        }
        if (fast[0].last.epoch != seen)
            slow_turn(&slow);
        seen = fast[0].last.epoch;
        if (fast[0].n_commits >= WARM_EPOCHS) {
            most = rss_kib(pid) > most ? rss_kib(pid) : most;
            rss = rss ? rss : most;
        }
    }
    for (unsigned k = 0; k < N_FAST; k++)
        good &= kept_up(&fast[k]);
    compare(&slow, &fast[0]);
    printf("memory: %ld KiB after %d epochs, at most %ld KiB\n", rss, WARM_EPOCHS, most);
    if (!SANITIZED && most > rss + RSS_MORE_KIB)
        die("the service's memory grew by %ld KiB", most - rss);
    if (waitpid(stuck, &status, 0) != stuck || status)
        die("the stuck one was not thrown out");
    printf("stuck: %ld\n", (long)stuck);
    if (!good && n_stalls) {
        printf("the machine is too busy: it held this program up %u times\n", n_stalls);
        return 77;
    }
    return good ? 0 : 1;
}
