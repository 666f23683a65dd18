/*
 * A service for which one allocation fails, in turn each of those that it makes from reading its
 * configuration on until it has served two subscribers and a status: it ends with an error that has
 * a text, or it serves. Whoever was turned away is served when it comes again. Each service is a
 * process of its own.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include "client/dexel.h"
#include "daemon/config.h"
#include "daemon/log.h"
#include "daemon/service.h"
#include "tests/unit/fail_alloc.h"

#define MOST_CALLS  20000 /* it ends long before */
#define PATIENCE_MS 20000 /* guards against hanging; nothing is measured by it */

/* What the service says when it ends: in memory that both processes have. */
struct outcome {
    int result;
    bool has_failed;
    char text[sizeof(((struct dx_err *)0)->text)];
};

struct place {
    char dir[32], config[64], mesh[64], control[64];
    struct outcome *outcome;
};

static void write_config(const struct place *p)
{
    FILE *f = fopen(p->config, "w");

    assert_non_null(f);
    fprintf(f,
            "socket: %s\ncontrol_socket: %s\nthreads: 2\nlog_level: error\n"
            "streams:\n"
            "  - name: hall\n    synthetic:\n      scene: hall\n      size: 96x80\n"
            "    record:\n      path: %s/rec.mcap\n"
            "      start: true\n",
            p->mesh, p->control, p->dir);
    assert_int_equal(fclose(f), 0);
}

static int make_place(void **state)
{
    static struct place p = {.dir = "/tmp/dexeld-oom-XXXXXX"};

    assert_non_null(mkdtemp(p.dir));
    snprintf(p.config, sizeof(p.config), "%s/c.yaml", p.dir);
    snprintf(p.mesh, sizeof(p.mesh), "%s/mesh", p.dir);
    snprintf(p.control, sizeof(p.control), "%s/control", p.dir);
    p.outcome =
        mmap(NULL, sizeof(*p.outcome), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    assert_true(p.outcome != MAP_FAILED);
    write_config(&p);
    *state = &p;
    return 0;
}

static int remove_place(void **state)
{
    const struct place *p = *state;
    char command[64];

    snprintf(command, sizeof(command), "rm -r %s", p->dir);
    return system(command);
}

/* ---- the service ---------------------------------------------------------------------------- */

static void serve(const struct place *p, uint64_t n, int ready_fd)
{
    struct outcome *o = p->outcome;
    struct dx_config config;
    struct dx_err err = {""};

    prctl(PR_SET_PDEATHSIG, SIGKILL);
    fail_alloc_arm(n);
    o->result = dx_config_load(&config, p->config, &err);
    if (o->result == 0)
        o->result = dx_service_run(&config, p->config, ready_fd, &err);
    o->has_failed = fail_alloc_has_failed();
    memcpy(o->text, err.text, sizeof(o->text));
    _exit(0);
}

static pid_t start(const struct place *p, uint64_t n, int *ready_fd)
{
    int ends[2];
    pid_t pid;

    *p->outcome = (struct outcome){.result = INT32_MIN};
    assert_int_equal(pipe(ends), 0);
    pid = fork();
    assert_true(pid >= 0);
    if (pid == 0) {
        close(ends[0]);
        serve(p, n, ends[1]);
    }
    close(ends[1]);
    *ready_fd = ends[0];
    return pid;
}

/* ---- its clients ---------------------------------------------------------------------------- */

static int on_commit(void *user, const struct dexel_commit *commit)
{
    (void)user;
    (void)commit;
    return 1;
}

static int on_state(void *user, enum dexel_state state, const char *reason)
{
    (void)user;
    (void)reason;
    return state == DEXEL_FAULTED || state == DEXEL_ENDED || state == DEXEL_GONE ? 2 : 0;
}

/* 1: it got a mesh; 2: it was told that there is none; negative: turned away. */
static int subscribe(const struct place *p)
{
    const struct dexel_callbacks callbacks = {.commit = on_commit, .state = on_state};
    const struct dexel_options options = {.socket = p->mesh, .encoding = DEXEL_Q16};
    struct dexel *d;
    int r = dexel_open(&d, &options, &callbacks, NULL);

    if (r == 0)
        r = dexel_run(d, PATIENCE_MS);
    dexel_close(d);
    if (r == -ETIMEDOUT)
        fail_msg("a subscriber was left without an answer");
    return r;
}

/* Bytes of an answer; 0: turned away. */
static size_t ask_status(const struct place *p)
{
    static const char request[] = "{\"request\":\"status\"}\n";
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, SOCK_STREAM, 0);
    struct pollfd pfd = {fd, POLLIN, 0};
    char answer[16384];
    ssize_t n = 0;

    assert_true(fd >= 0);
    memcpy(at.sun_path, p->control, strlen(p->control) + 1);
    if (connect(fd, (struct sockaddr *)&at, sizeof(at)) == 0 &&
        send(fd, request, strlen(request), MSG_NOSIGNAL) > 0) {
        if (poll(&pfd, 1, PATIENCE_MS) == 0)
            fail_msg("a status was left without an answer");
        n = recv(fd, answer, sizeof(answer), 0);
    }
    close(fd);
    return n > 0 ? (size_t)n : 0;
}

static void use(const struct place *p, uint64_t n)
{
    const int first = subscribe(p), second = subscribe(p);
    const size_t status = ask_status(p);

    if (first < 0 && second < 0)
        fail_msg("call %llu: two subscribers were turned away: %s", (unsigned long long)n,
                 strerror(-second));
    if (!status && !ask_status(p))
        fail_msg("call %llu: status was refused twice", (unsigned long long)n);
}

/* ---- the test ------------------------------------------------------------------------------- */

static void await_end(pid_t pid, uint64_t n)
{
    int status;

    alarm(PATIENCE_MS / 1000); /* ends the test: a service that does not stop */
    assert_int_equal(waitpid(pid, &status, 0), pid);
    alarm(0);
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
        fail_msg("call %llu: the service ended by status %#x", (unsigned long long)n,
                 (unsigned)status);
}

/* False: that call was never made. */
static bool try_one(const struct place *p, uint64_t n)
{
    const struct outcome *o = p->outcome;
    int ready_fd;
    const pid_t pid = start(p, n, &ready_fd);
    struct pollfd pfd = {ready_fd, POLLIN, 0};
    char line[16];

    if (poll(&pfd, 1, PATIENCE_MS) == 0)
        fail_msg("call %llu: neither ready nor at an end", (unsigned long long)n);
    if (read(ready_fd, line, sizeof(line)) > 0) {
        use(p, n);
        kill(pid, SIGTERM);
    }
    close(ready_fd);
    await_end(pid, n);
    if (o->result < 0 && !o->text[0])
        fail_msg("call %llu: error %d without a text", (unsigned long long)n, o->result);
    if (o->result < 0 && !o->has_failed)
        fail_msg("with all memory: %s", o->text);
    return o->has_failed;
}

static void each_call_may_fail(void **state)
{
    uint64_t n = 1;

    while (n < MOST_CALLS && try_one(*state, n))
        n++;
    print_message("%llu calls\n", (unsigned long long)(n - 1));
    assert_in_range(n, 100, MOST_CALLS - 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(each_call_may_fail, make_place, remove_place),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
