/*
 * outlive DEXELD CONFIG SOCKET: a subscriber that is there before the service and stays when that
 * is killed, or stops, and comes again. It is told that the service is gone, then begins anew, and
 * after that holds what a new subscriber holds at the same epoch. A service that is held up for a
 * while goes on where it was. The service is our child.
 */
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/system/follower.h"

#define N_ROUNDS 6
#define PAUSE_MS 5000

static pid_t start_service(const char *dexeld, const char *config)
{
    pid_t pid = fork();

    if (pid == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        execl(dexeld, dexeld, "-c", config, (char *)NULL);
        _exit(127);
    }
    if (pid < 0)
        die("no process");
    return pid;
}

static void expect_running(pid_t pid)
{
    if (waitpid(pid, NULL, WNOHANG))
        die("the service did not stay");
}

static void await_commits(struct follower *f, unsigned n, pid_t service)
{
    while (f->n_commits < n) {
        expect_running(service);
        followers_turn(&f, 1, -1);
    }
}

/* Nothing comes for so long; then all goes on, and nobody is turned out. */
static void hold_up(struct follower *f, pid_t service)
{
    const unsigned n_resets = f->n_resets, n_gone = f->n_gone;
    struct pollfd p = {dexel_fd(f->d), POLLIN, 0};

    kill(service, SIGSTOP);
    while (poll(&p, 1, PAUSE_MS) > 0)
        follower_turn(f);
    kill(service, SIGCONT);
    await_commits(f, f->n_commits + 3, service);
    if (f->n_resets != n_resets || f->n_gone != n_gone)
        die("a pause of the service cost %u resets, %u connections", f->n_resets - n_resets,
            f->n_gone - n_gone);
}

static void end_service(pid_t pid, int signal)
{
    int status;

    kill(pid, signal);
    if (waitpid(pid, &status, 0) != pid)
        die("the service did not end");
    if (signal == SIGTERM && !(WIFEXITED(status) && WEXITSTATUS(status) == 0))
        die("the service ended by status %#x", (unsigned)status);
}

static void await_gone(struct follower *f, unsigned n)
{
    while (f->n_gone < n)
        followers_turn(&f, 1, -1);
    if (f->n_gone != n || f->state != DEXEL_GONE)
        die("told %u times that the service is gone, expected %u", f->n_gone, n);
}

/* In pull mode: what is asked for while there is no service is asked of the one that comes, and
 * each batch is one commit. */
static void pull(const char *dexeld, const char *config, const char *socket)
{
    static struct follower f = {.name = "puller", .reconnect = true, .mode = DEXEL_PULL};
    pid_t service;

    follower_open(&f, socket, NULL, DEXEL_Q16);
    await_gone(&f, 1);
    for (int k = 0; k < 2; k++)
        if (dexel_next(f.d) < 0)
            die("asked for a batch of no service: %s", dexel_error(f.d));
    service = start_service(dexeld, config);
    await_commits(&f, 2, service);
    end_service(service, SIGTERM);
    await_gone(&f, 2);
    if (f.n_commits != 2)
        die("%u batches, asked for 2", f.n_commits);
    follower_close(&f);
}

/* A new subscriber and it hold the same at an epoch that both had. */
static void compare(struct follower *f, const char *socket)
{
    static struct follower fresh;
    struct follower *both[] = {f, &fresh};
    bool same = false;

    memset(&fresh, 0, sizeof(fresh));
    fresh.name = "fresh";
    follower_open(&fresh, socket, NULL, DEXEL_F32);
    while (!same) {
        const struct follower_commit *its, *mine;

        followers_turn(both, 2, -1);
        its = follower_at(f, fresh.last.epoch);
        mine = follower_at(&fresh, fresh.last.epoch);
        if (!its || !mine)
            continue;
        if (its->digest != mine->digest)
            die("epoch %llu: another mesh than that of a new subscriber",
                (unsigned long long)fresh.last.epoch);
        same = true;
    }
    follower_close(&fresh);
}

int main(int argc, char **argv)
{
    static struct follower f = {.name = "faithful", .reconnect = true};

    if (argc != 4)
        die("usage: outlive DEXELD CONFIG SOCKET");
    pull(argv[1], argv[2], argv[3]);
    follower_open(&f, argv[3], NULL, DEXEL_Q16);
    await_gone(&f, 1); /* there is none yet */
    for (unsigned k = 0; k < N_ROUNDS; k++) {
        pid_t service = start_service(argv[1], argv[2]);
        unsigned n_commits = f.n_commits;

        memset(f.history, 0, sizeof(f.history)); /* a new service counts from 1 */
        await_commits(&f, n_commits + 3, service);
        if (f.n_resets != k)
            die("%u resets, expected %u", f.n_resets, k);
        compare(&f, argv[3]);
        if (k == 0)
            hold_up(&f, service);
        end_service(service, k % 2 ? SIGTERM : SIGKILL);
        await_gone(&f, k + 2);
    }
    printf("%d services, %u commits\n", N_ROUNDS, f.n_commits);
    follower_close(&f);
    return 0;
}
