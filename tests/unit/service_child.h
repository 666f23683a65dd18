/*
 * A service in a process of its own, with its configuration and sockets in a folder of its own, and
 * clients of it. fail_each_call(): a service for which one call of a kind fails, in turn each of
 * those that it makes from reading its configuration on until it has served two subscribers and has
 * answered requests: it ends with an error that has a text, or it serves. Whoever was turned away
 * is served when it comes again.
 */
#ifndef SERVICE_CHILD_H
#define SERVICE_CHILD_H

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
#include "tests/unit/rounds.h"

#define MOST_CALLS  20000  /* it ends long before */
#define PATIENCE_MS 300000 /* guards against hanging; nothing is measured by it */

/* What the service says when it ends: in memory that both processes have. */
struct outcome {
    int result;
    bool has_failed;
    int why; /* 0: not asked for */
    char text[sizeof(((struct dx_err *)0)->text)];
};

/* Which call fails, and what the service is asked for after two meshes. */
struct failing_calls {
    void (*arm)(uint64_t n); /* call number n from here on; 0: none */
    bool (*has_failed)(void);
    int (*why)(void); /* the errno of it, of which an error's text must tell; NULL: it need not */
    bool metrics;     /* it writes a metrics_file */
    const char *const *requests; /* ended by NULL */
};

struct place {
    char dir[32], config[64], mesh[64], control[64];
    struct outcome *outcome;
    const struct failing_calls *calls; /* NULL: none fails */
};

static inline void write_config(const struct place *p)
{
    FILE *f = fopen(p->config, "w");
    char metrics[96] = "";

    if (p->calls && p->calls->metrics)
        snprintf(metrics, sizeof(metrics), "metrics_file: %s/metrics\n", p->dir);
    assert_non_null(f);
    fprintf(f,
            "socket: %s\ncontrol_socket: %s\nthreads: 2\nlog_level: error\n"
            "%sstreams:\n"
            "  - name: hall\n    synthetic:\n      scene: hall\n      size: 96x80\n"
            "    record:\n      path: %s/rec.mcap\n"
            "      start: true\n",
            p->mesh, p->control, metrics, p->dir);
    assert_int_equal(fclose(f), 0);
}

static inline int make_place(void **state)
{
    static struct place p;

    p = (struct place){.dir = "/tmp/dexeld-child-XXXXXX", .calls = *state};
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

static inline int remove_place(void **state)
{
    const struct place *p = *state;
    char command[64];

    snprintf(command, sizeof(command), "rm -r %s", p->dir);
    return system(command);
}

/* ---- the service ---------------------------------------------------------------------------- */

static inline void serve(const struct place *p, uint64_t n, int ready_fd)
{
    struct outcome *o = p->outcome;
    struct dx_config config;
    struct dx_err err = {""};

    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (p->calls)
        p->calls->arm(n);
    o->result = dx_config_load(&config, p->config, &err);
    if (o->result == 0)
        o->result = dx_service_run(&config, p->config, ready_fd, &err);
    o->has_failed = p->calls && p->calls->has_failed();
    o->why = p->calls && p->calls->why ? p->calls->why() : 0;
    if (p->calls)
        p->calls->arm(0);
    memcpy(o->text, err.text, sizeof(o->text));
    if (o->result == DX_SERVICE_E_LEFT)
        _exit(0); /* as dexeld does */
    dx_config_fini(&config);
    exit(0); /* a sanitizer looks for what was not freed, and counts of lines are written */
}

static inline pid_t start(const struct place *p, uint64_t n, int *ready_fd)
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

/* False: it has ended instead. */
static inline bool is_ready(int ready_fd, uint64_t n)
{
    struct pollfd pfd = {ready_fd, POLLIN, 0};
    char line[16];
    bool ready;

    if (poll(&pfd, 1, PATIENCE_MS) == 0)
        fail_msg("call %llu: neither ready nor at an end", (unsigned long long)n);
    ready = read(ready_fd, line, sizeof(line)) > 0;
    close(ready_fd);
    return ready;
}

/* ---- its clients ---------------------------------------------------------------------------- */

static inline int on_commit(void *user, const struct dexel_commit *commit)
{
    (void)user;
    (void)commit;
    return 1;
}

static inline int on_state(void *user, enum dexel_state state, const char *reason)
{
    (void)user;
    (void)reason;
    return state == DEXEL_FAULTED || state == DEXEL_ENDED || state == DEXEL_GONE ? 2 : 0;
}

/* 1: it got a mesh; 2: it was told that there is none; negative: turned away. */
static inline int subscribe(const struct place *p, const char *stream)
{
    const struct dexel_callbacks callbacks = {.commit = on_commit, .state = on_state};
    const struct dexel_options options = {
        .socket = p->mesh, .stream = stream, .encoding = DEXEL_Q16};
    struct dexel *d;
    int r = dexel_open(&d, &options, &callbacks, NULL);

    if (r == 0)
        r = dexel_run(d, PATIENCE_MS);
    dexel_close(d);
    if (r == -ETIMEDOUT)
        fail_msg("a subscriber was left without an answer");
    return r;
}

/* A connection to the control socket on which this was asked; -1: turned away. */
static inline int begin_asking(const struct place *p, const char *request)
{
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, SOCK_STREAM, 0);

    assert_true(fd >= 0);
    memcpy(at.sun_path, p->control, strlen(p->control) + 1);
    if (connect(fd, (struct sockaddr *)&at, sizeof(at)) == 0 &&
        send(fd, request, strlen(request), MSG_NOSIGNAL) > 0)
        return fd;
    close(fd);
    return -1;
}

/* The next line of answer; NULL: turned away. Valid until the next one. A byte at a time, so that
 * what follows stays where it is. */
static inline const char *hear_next(int fd, const char *request)
{
    static char answer[1 << 16];
    struct pollfd pfd = {fd, POLLIN, 0};
    size_t len = 0;
    ssize_t n = 1;

    while (fd >= 0 && n > 0 && (len == 0 || answer[len - 1] != '\n') && len < sizeof(answer) - 1) {
        if (poll(&pfd, 1, PATIENCE_MS) == 0)
            fail_msg("left without an answer: %.60s", request);
        n = recv(fd, answer + len, 1, 0);
        len += n > 0 ? (size_t)n : 0;
    }
    answer[len] = '\0';
    return len ? answer : NULL;
}

/* The same, and the last thing that is heard. */
static inline const char *hear(int fd, const char *request)
{
    const char *answer = hear_next(fd, request);

    if (fd >= 0)
        close(fd);
    return answer;
}

static inline const char *ask(const struct place *p, const char *request)
{
    return hear(begin_asking(p, request), request);
}

static inline void use(const struct place *p, uint64_t n)
{
    const int first = subscribe(p, NULL), second = subscribe(p, NULL);

    if (first < 0 && second < 0)
        fail_msg("call %llu: two subscribers were turned away: %s", (unsigned long long)n,
                 strerror(-second));
    for (const char *const *request = p->calls->requests; *request; request++) {
        const char *answered = ask(p, *request);

        if (!answered)
            answered = ask(p, *request);
        if (!answered)
            fail_msg("call %llu: refused twice: %s", (unsigned long long)n, *request);
    }
}

/* ---- each call ------------------------------------------------------------------------------- */

static inline void await_end(pid_t pid, uint64_t n)
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
static inline bool try_one(const struct place *p, uint64_t n)
{
    const struct outcome *o = p->outcome;
    int ready_fd;
    const pid_t pid = start(p, n, &ready_fd);

    if (is_ready(ready_fd, n)) {
        use(p, n);
        kill(pid, SIGTERM);
    }
    await_end(pid, n);
    if (o->result < 0 && !o->text[0])
        fail_msg("call %llu: error %d without a text", (unsigned long long)n, o->result);
    if (o->result < 0 && o->why && !strstr(o->text, strerror(o->why)))
        fail_msg("call %llu: '%s', expected '%s' in it", (unsigned long long)n, o->text,
                 strerror(o->why));
    if (o->result < 0 && !o->has_failed)
        fail_msg("with all memory: %s", o->text);
    return o->has_failed;
}

/* How many calls there are. */
static inline uint64_t fail_each_call(const struct place *p)
{
    uint64_t n = 1;

    while (n < MOST_CALLS && try_one(p, n))
        n += EACH;
    print_message("%llu calls\n", (unsigned long long)(n - 1));
    assert_true(n < MOST_CALLS);
    return n - 1;
}

#endif
